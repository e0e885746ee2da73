#include "drivers/mru/mru_wire_nmea.hpp"

#include <algorithm>

namespace motionlab::mru::nmea {
namespace {

constexpr int kInvalid = 2;
constexpr int kAttitudesPerRates = 2;

struct Name {
  Kind kind;
  std::string_view text;  ///< with the comma behind it
};
constexpr std::array kNames{Name{Kind::quality, "PSXN,20,"}, Name{Kind::restart, "PSXN,21,"},
                            Name{Kind::gyro, "PSXN,22,"},    Name{Kind::attitude, "PSXN,23,"},
                            Name{Kind::rates, "PSXN,24,"},   Name{Kind::prdid, "PRDID,"}};

}  // namespace

Result<Sentence> decode(std::string_view text) noexcept {
  const Result<sentence::Opened> opened = sentence::open(text, kMaxSentence);
  if (!opened) return opened.fault();
  std::string_view body = opened->body;

  Sentence sentence;
  sentence.checksum = opened->checksum;
  const auto name =
      std::ranges::find_if(kNames, [&](const Name& known) { return body.starts_with(known.text); });
  if (name == kNames.end()) return sentence;
  sentence.kind = name->kind;
  body.remove_prefix(name->text.size());
  const std::size_t fields = sentence::field_count(body);
  if (fields != value_count(sentence.kind)) {
    return Fault{Reason::bad_header, "the sentence has another number of fields than its kind"};
  }
  for (std::size_t i = 0; i < fields; ++i) {
    const std::optional<double> value = sentence::number(sentence::take_field(body));
    if (!value) return Fault{Reason::bad_value, "a field of the sentence is no number"};
    sentence.values[i] = *value;
  }
  return sentence;
}

Result<Bytes> encode(const Sentence& sentence, MutableBytes to) noexcept {
  const auto name =
      std::ranges::find_if(kNames, [&](const Name& known) { return known.kind == sentence.kind; });
  if (name == kNames.end()) return Fault{Reason::bad_value, "a sentence of no known kind"};
  const bool whole_numbers = sentence.kind == Kind::quality || sentence.kind == Kind::restart;
  sentence::Writer writer{to};
  writer.put(name->text);
  for (std::size_t i = 0; i < value_count(sentence.kind); ++i) {
    if (i > 0) writer.put(",");
    writer.put(sentence.values[i], whole_numbers ? 0 : 2);
  }
  return writer.finish();
}

Result<std::optional<Telegram>> Listener::take(Bytes datagram) noexcept {
  std::optional<Telegram> told;
  bool known = false, believed = false;
  std::string_view rest = as_text(datagram);
  do {
    const std::size_t end = rest.find('\n');
    const std::string_view line = end == std::string_view::npos ? rest : rest.substr(0, end + 1);
    rest.remove_prefix(line.size());
    const Result<Sentence> sentence = decode(line);
    if (!sentence) return sentence.fault();
    if (!belongs(sentence->kind)) continue;
    known = true;
    if (sentence->kind == attitude_) {
      told = tell(*sentence);
      believed = true;
    } else if (sentence->checksum == Checksum::good) {
      remember(*sentence);
      believed = true;
    }
  } while (!rest.empty());
  if (!known) {
    return Fault{Reason::bad_header,
                 "no sentence of the configured kind: set the unit to PSXN or PRDID, or the format"};
  }
  if (!believed) return Fault{Reason::bad_checksum, "the checksum of the sentence is missing or wrong"};
  return told;
}

bool Listener::belongs(Kind kind) const noexcept {
  if (attitude_ == Kind::prdid) return kind == Kind::prdid;
  return kind != Kind::prdid && kind != Kind::other;
}

void Listener::remember(const Sentence& sentence) noexcept {
  const auto& values = sentence.values;
  // An empty or unknown quality is no good one.
  const auto quality = [](double value) { return value == 0.0 ? 0 : value == 1.0 ? 1 : kInvalid; };
  if (sentence.kind == Kind::quality) {
    heading_quality_ = quality(values[2]);
    roll_pitch_quality_ = quality(values[3]);
    quality_heard_ = true;
    waits_for_quality_ = false;
  } else if (sentence.kind == Kind::restart && values[0] == 1.0) {
    waits_for_quality_ = quality_heard_;
    rates_hold_ = 0;
  } else if (sentence.kind == Kind::rates) {
    rates_ = values;
    rates_hold_ = kAttitudesPerRates;
  }
}

Telegram Listener::tell(const Sentence& sentence) noexcept {
  Telegram telegram;
  Motion& motion = telegram.motion;
  const auto& values = sentence.values;
  const bool prdid = sentence.kind == Kind::prdid;
  const bool may_lack_checksum = prdid;
  const bool absent = sentence.checksum == Checksum::absent;
  telegram.check.rule = absent && may_lack_checksum ? Check::Rule::none : Check::Rule::known;
  telegram.check.good = sentence.checksum == Checksum::good || (absent && may_lack_checksum);

  motion.stable = roll_pitch_quality_ != kInvalid && !waits_for_quality_;
  motion.reduced = roll_pitch_quality_ == 1 || heading_quality_ == 1;
  motion.euler_heading_mru_rad = {kDegree * values[prdid ? 1 : 0], kDegree * values[prdid ? 0 : 1],
                                  heading_quality_ == kInvalid ? kNotTold : yaw_of_heading(values[2])};
  if (!prdid) motion.p_heading_origin_m[2] = values[3];
  if (rates_hold_ > 0) {
    --rates_hold_;
    for (std::size_t i = 0; i < 3; ++i) motion.omega_mru_radps[i] = kDegree * rates_[i];
    motion.v_heading_origin_mps[2] = rates_[3];
  }
  return telegram;
}

}  // namespace motionlab::mru::nmea
