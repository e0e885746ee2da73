#include "drivers/mru/mru_wire_sentence.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace motionlab::mru::sentence {
namespace {

constexpr std::string_view kEnd = "\r\n";
constexpr std::size_t kLongestNumber = 120;

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

}  // namespace

Result<Opened> open(std::string_view text, std::size_t longest) noexcept {
  if (text.size() > longest) return Fault{Reason::too_long, "longer than any sentence of the unit"};
  if (text.empty()) return Fault{Reason::too_short, "nothing where a sentence was expected"};
  if (text.front() != '$') {
    return Fault{Reason::bad_header, "the first character is not $: the port does not carry sentences"};
  }
  if (!text.ends_with(kEnd)) return Fault{Reason::too_short, "the sentence does not end with CR LF"};
  Opened opened;
  opened.body = text.substr(1, text.size() - 1 - kEnd.size());
  opened.checksum = take_checksum(opened.body);
  return opened;
}

std::string_view take_field(std::string_view& rest) noexcept {
  const std::string_view field = rest.substr(0, rest.find(','));
  rest.remove_prefix(std::min(rest.size(), field.size() + 1));
  return field;
}

std::size_t field_count(std::string_view fields) noexcept {
  return static_cast<std::size_t>(std::ranges::count(fields, ',')) + 1;
}

std::optional<double> number(std::string_view field) noexcept {
  if (field.empty()) return std::numeric_limits<double>::quiet_NaN();
  if (field.find_first_not_of("0123456789.-") != std::string_view::npos) return std::nullopt;
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(field.data(), field.data() + field.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

Writer::Writer(MutableBytes to) noexcept : to_(to), writer_(to) {
  put("$");
}

void Writer::put(double value, int decimals) noexcept {
  if (std::isnan(value)) return;
  std::array<char, kLongestNumber> digits{};
  // What rounds to zero has no sign.
  const double shown = std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
  const auto [end, error] =
      std::to_chars(digits.data(), digits.data() + digits.size(), shown, std::chars_format::fixed, decimals);
  failed_ = failed_ || error != std::errc{};
  if (!failed_) put({digits.data(), static_cast<std::size_t>(end - digits.data())});
}

Result<Bytes> Writer::finish() noexcept {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  constexpr Fault kNoRoom{Reason::too_short, "no room for the sentence"};
  if (!writer_.ok() || failed_) return kNoRoom;
  const std::uint8_t checksum = xor_of(as_text(writer_.written()).substr(1));
  put("*");
  put(kDigits.substr(checksum >> 4, 1));
  put(kDigits.substr(checksum & 0xF, 1));
  put(kEnd);
  if (!writer_.ok()) return kNoRoom;
  return Bytes{to_.first(writer_.position())};
}

}  // namespace motionlab::mru::sentence
