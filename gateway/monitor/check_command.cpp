#include "gateway/monitor/check_command.hpp"

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>
#include <span>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/error.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"

namespace motionlab::monitor {
namespace {

constexpr std::chrono::milliseconds kPoll{20};

mru::VariableList variable_list(const std::vector<std::uint16_t>& numbers) {
  if (numbers.empty()) return mru::VariableList::laboratory();
  std::vector<mru::Variable> variables;
  for (const std::uint16_t number : numbers) variables.push_back(static_cast<mru::Variable>(number));
  // Whatever is not in the table is taken for a float: of the unit's variables only times are not.
  const auto list = mru::VariableList::of(variables, variables);
  if (!list) throw StartupError("--variables: " + std::string{list.fault().text});
  return *list;
}

/// "roll 1.146 deg, pitch -1.719 deg, yaw 28.648 deg, heave -0.350 m (down)", what is not told left out.
std::string sample_text(const mru::Motion& motion) {
  std::string text;
  const auto add = [&](const char* name, double value, double unit, const char* unit_name) {
    if (std::isnan(value)) return;
    text += (text.empty() ? "" : ", ") + std::string{name} + " " + fixed(value / unit, 3) + " " + unit_name;
  };
  add("roll", motion.euler_heading_mru_rad[0], mru::kDegree, "deg");
  add("pitch", motion.euler_heading_mru_rad[1], mru::kDegree, "deg");
  add("yaw", motion.euler_heading_mru_rad[2], mru::kDegree, "deg");
  add("heave", motion.p_heading_origin_m[2], 1.0, "m (down)");
  add("roll rate", motion.omega_mru_radps[0], mru::kDegree, "deg/s");
  add("pitch rate", motion.omega_mru_radps[1], mru::kDegree, "deg/s");
  add("yaw rate", motion.omega_mru_radps[2], mru::kDegree, "deg/s");
  return text;
}

std::string checksum_text(mru::Format format, const MruStream::Checksums& sums) {
  const auto share = [&](std::uint64_t n) {
    return std::to_string(n) + " of " + std::to_string(sums.decoded);
  };
  if (format == mru::Format::mrubin) {
    return "sum8 in " + share(sums.sum8) + ", ones_complement in " + share(sums.ones_complement);
  }
  return "right or none in " + share(sums.good);
}

/// NaN becomes null.
nlohmann::ordered_json to_json(const MruStream& stream) {
  const mru::FormatDetector& seen = stream.detector();
  const auto format = seen.format();
  nlohmann::ordered_json json;
  json["format"] = nullptr;
  if (format) json["format"] = mru::to_string(*format);
  json["datagrams"] = seen.datagrams();
  json["bytes"] = seen.size();
  json["rate_hz"] = stream.rate_hz();
  json["from"] = nullptr;
  if (stream.from()) json["from"] = to_string(*stream.from());
  if (format && mru::has_list(*format)) {
    json["token"] = *seen.token();
    json["variables"] = seen.variables();
  }
  if (format == mru::Format::mrubin) {
    json["checksum_sum8"] = stream.checksums().sum8;
    json["checksum_ones_complement"] = stream.checksums().ones_complement;
  }
  json["decoded"] = stream.checksums().decoded;
  json["checksum_good"] = stream.checksums().good;
  json["sample"] = nullptr;
  if (const auto motion = stream.newest()) {
    json["sample"] = {{"stable", motion->stable},
                      {"euler_heading_mru_rad", motion->euler_heading_mru_rad},
                      {"omega_mru_radps", motion->omega_mru_radps},
                      {"p_heading_origin_m", motion->p_heading_origin_m}};
  }
  return json;
}

void print(const MruStream& stream, mru::Format format, std::ostream& out) {
  const mru::FormatDetector& seen = stream.detector();
  out << "format    " << mru::to_string(format) << ", " << seen.size() << " bytes";
  if (mru::has_list(format)) {
    out << ", token " << int{*seen.token()} << ", " << seen.variables() << " variables";
  }
  out << "\nstream    " << seen.datagrams() << " datagrams, " << fixed(stream.rate_hz(), 1) << " Hz, from "
      << to_string(*stream.from()) << "\n";
  if (stream.checksums().decoded > 0) {
    out << "checksum  " << checksum_text(format, stream.checksums()) << "\n";
  }
  if (const auto motion = stream.newest()) {
    out << "sample    " << (motion->stable ? "stable" : "not stable") << ": " << sample_text(*motion) << "\n";
  }
}

/// What hinders, when no sample can be shown.
std::string trouble(const MruStream& stream) {
  const mru::FormatDetector& seen = stream.detector();
  if (!seen.format()) {
    return std::to_string(seen.datagrams()) + " datagrams came, the last of " + std::to_string(seen.size()) +
           " bytes, but of no known format, or too few of one: listen longer (--seconds)";
  }
  if (stream.fault()) {
    return std::string{stream.fault()->text} +
           (mru::has_list(*seen.format()) ? "; tell the unit's list of variables with --variables, by number"
                                          : "");
  }
  return "no attitude has come";
}

}  // namespace

void MruStream::take(Bytes datagram, Endpoint from, LabTime t_received) {
  if (!t_first_) t_first_ = t_received;
  t_last_ = t_received;
  from_ = from;
  detector_.take(datagram);
  if (detector_.format()) decode(datagram);
}

void MruStream::decode(Bytes datagram) {
  if (!decoder_) {
    mru::Layout layout;
    layout.variables = variables_;
    layout.token = detector_.token().value_or(layout.token);
    decoder_.emplace(*detector_.format(), layout);
  }
  const auto heard = decoder_->decode(datagram);
  fault_ = heard ? std::nullopt : std::optional{heard.fault()};
  if (!heard || !*heard) return;
  const auto& [motion, check] = **heard;
  newest_ = motion;
  ++checksums_.decoded;
  checksums_.good += check.good ? 1 : 0;
  checksums_.sum8 += check.match.sum8 ? 1 : 0;
  checksums_.ones_complement += check.match.ones_complement ? 1 : 0;
}

double MruStream::rate_hz() const noexcept {
  if (!t_first_ || t_last_ <= *t_first_) return 0.0;
  return static_cast<double>(detector_.datagrams() - 1) / seconds(t_last_ - *t_first_);
}

MruStream listen_to_mru(const CheckMruCommand& command, const std::atomic<bool>& interrupted) {
  MruStream stream{variable_list(command.variables)};
  boost::asio::io_context io;
  const RealClock clock;
  AsioNetwork network{io, clock};
  const auto socket = network.datagram({0, command.port});
  socket->on_datagram([&](Bytes datagram, Endpoint from, LabTime t) { stream.take(datagram, from, t); });
  for (const LabTime end = clock.now() + from_seconds(command.seconds); clock.now() < end && !interrupted;) {
    io.restart();
    io.run_for(kPoll);
  }
  socket->on_datagram({});
  return stream;
}

int run_check_mru(const CheckMruCommand& command, const Terminal& terminal) {
  const MruStream stream = listen_to_mru(command, terminal.interrupted);
  const auto format = stream.detector().format();
  if (command.json) {
    terminal.out << json_text(to_json(stream));
  } else if (format) {
    print(stream, *format, terminal.out);
  }
  if (format && stream.newest()) return kExitGood;
  if (stream.detector().datagrams() == 0) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << "nothing has come to udp port " << command.port << " in " << fixed(command.seconds, 1)
                 << " s: check the unit's destination address and port, and its cable\n";
    return kExitNobody;
  }
  terminal.err << trouble(stream) << "\n";
  return kExitWrong;
}

}  // namespace motionlab::monitor
