#include "drivers/mru/mru_wire_nmea.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace motionlab::mru::nmea {
namespace {

constexpr std::string_view kEnd = "\r\n";
constexpr int kInvalid = 2;
constexpr int kAttitudesPerRates = 2;

struct Name {
  Kind kind;
  std::string_view text;  ///< with the comma behind it
};
constexpr std::array kNames{Name{Kind::quality, "PSXN,20,"}, Name{Kind::restart, "PSXN,21,"},
                            Name{Kind::gyro, "PSXN,22,"},    Name{Kind::attitude, "PSXN,23,"},
                            Name{Kind::rates, "PSXN,24,"},   Name{Kind::prdid, "PRDID,"}};

std::uint8_t xor_of(std::string_view text) noexcept {
  std::uint8_t sum = 0;
  for (const char c : text) sum ^= static_cast<std::uint8_t>(c);
  return sum;
}

/// Takes `*h` or `*hh` off the end of a sentence's body and judges it.
Checksum take_checksum(std::string_view& body) noexcept {
  const std::size_t star = body.rfind('*');
  if (star == std::string_view::npos) return Checksum::absent;
  const std::string_view digits = body.substr(star + 1);
  body = body.substr(0, star);
  unsigned said = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), said, 16);
  const bool whole = error == std::errc{} && end == digits.data() + digits.size() && digits.size() <= 2;
  return whole && said == xor_of(body) ? Checksum::good : Checksum::bad;
}

/// A decimal number without an exponent; NaN for an empty field; nothing for anything else.
std::optional<double> number(std::string_view field) noexcept {
  if (field.empty()) return kNotTold;
  if (field.find_first_not_of("0123456789.-") != std::string_view::npos) return std::nullopt;
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(field.data(), field.data() + field.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

class TextWriter {
 public:
  explicit TextWriter(MutableBytes to) noexcept : to_(to), writer_(to) {}

  void put(std::string_view text) noexcept { writer_.write_bytes(as_bytes(text)); }
  void put(double value, int decimals) noexcept {
    if (std::isnan(value)) return;
    std::array<char, kMaxSentence> digits{};
    // What rounds to zero has no sign.
    const double shown = std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), shown,
                                            std::chars_format::fixed, decimals);
    put({digits.data(), static_cast<std::size_t>(end - digits.data())});
    failed_ = failed_ || error != std::errc{};
  }
  void put_hex(std::uint8_t value) noexcept {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    put(kDigits.substr(value >> 4, 1));
    put(kDigits.substr(value & 0xF, 1));
  }
  [[nodiscard]] std::string_view text() const noexcept { return as_text(writer_.written()); }
  [[nodiscard]] Bytes bytes() const noexcept { return Bytes{to_.first(writer_.position())}; }
  [[nodiscard]] bool ok() const noexcept { return writer_.ok() && !failed_; }

 private:
  MutableBytes to_;
  LittleWriter writer_;
  bool failed_ = false;
};

}  // namespace

Result<Sentence> decode(std::string_view text) noexcept {
  if (text.size() > kMaxSentence) return Fault{Reason::too_long, "longer than any sentence of the unit"};
  if (text.empty()) return Fault{Reason::too_short, "nothing where a sentence was expected"};
  if (text.front() != '$') {
    return Fault{Reason::bad_header, "the first character is not $: the port does not carry sentences"};
  }
  if (!text.ends_with(kEnd)) return Fault{Reason::too_short, "the sentence does not end with CR LF"};
  std::string_view body = text.substr(1, text.size() - 1 - kEnd.size());

  Sentence sentence;
  sentence.checksum = take_checksum(body);
  const auto name =
      std::ranges::find_if(kNames, [&](const Name& known) { return body.starts_with(known.text); });
  if (name == kNames.end()) return sentence;
  sentence.kind = name->kind;
  body.remove_prefix(name->text.size());
  const auto commas = static_cast<std::size_t>(std::ranges::count(body, ','));
  if (commas + 1 != value_count(sentence.kind)) {
    return Fault{Reason::bad_header, "the sentence has another number of fields than its kind"};
  }
  for (std::size_t i = 0; i <= commas; ++i) {
    const std::string_view field = body.substr(0, body.find(','));
    const std::optional<double> value = number(field);
    if (!value) return Fault{Reason::bad_value, "a field of the sentence is no number"};
    sentence.values[i] = *value;
    body.remove_prefix(std::min(body.size(), field.size() + 1));
  }
  return sentence;
}

Result<Bytes> encode(const Sentence& sentence, MutableBytes to) noexcept {
  const auto name =
      std::ranges::find_if(kNames, [&](const Name& known) { return known.kind == sentence.kind; });
  if (name == kNames.end()) return Fault{Reason::bad_value, "a sentence of no known kind"};
  const bool whole_numbers = sentence.kind == Kind::quality || sentence.kind == Kind::restart;
  TextWriter writer{to};
  writer.put("$");
  writer.put(name->text);
  for (std::size_t i = 0; i < value_count(sentence.kind); ++i) {
    if (i > 0) writer.put(",");
    writer.put(sentence.values[i], whole_numbers ? 0 : 2);
  }
  if (!writer.ok()) return Fault{Reason::too_short, "no room for the sentence"};
  const std::uint8_t checksum = xor_of(writer.text().substr(1));
  writer.put("*");
  writer.put_hex(checksum);
  writer.put(kEnd);
  if (!writer.ok()) return Fault{Reason::too_short, "no room for the sentence"};
  return writer.bytes();
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
