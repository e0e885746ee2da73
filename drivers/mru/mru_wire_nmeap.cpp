#include "drivers/mru/mru_wire_nmeap.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

namespace motionlab::mru::nmeap {
namespace {

constexpr int kDecimalsOfDegrees = 2;
constexpr int kDecimalsOfRadians = 6;

/// What one count of the sentence is in the unit of the variable table.
double unit_of(const VariableFacts& facts, const Layout& layout) noexcept {
  const bool angle = facts.quantity == Quantity::tilt || facts.quantity == Quantity::heading ||
                     facts.quantity == Quantity::rate;
  return angle && layout.text_in_degrees ? std::numbers::pi / 180.0 : 1.0;
}

std::optional<unsigned> token_in(std::string_view field) noexcept {
  unsigned token = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), token);
  const bool whole = error == std::errc{} && end == field.data() + field.size();
  return whole ? std::optional{token} : std::nullopt;
}

}  // namespace

Result<Sentence> decode(std::string_view text, const Layout& layout) noexcept {
  const Result<sentence::Opened> opened = sentence::open(text, kMaxSentence);
  if (!opened) return opened.fault();
  std::string_view rest = opened->body;
  const bool settled = rest.starts_with(kSettled);
  if (!settled && !rest.starts_with(kUnsettled)) {
    return Fault{Reason::bad_header, "neither PSXN,10 nor PSXN,11: the port does not carry NMEAP"};
  }
  rest.remove_prefix(kSettled.size());
  if (token_in(sentence::take_field(rest)) != layout.token) {
    return Fault{Reason::bad_header,
                 "another token: is this the port of the other unit? See the token setting"};
  }
  if (sentence::field_count(rest) != layout.variables.size()) {
    return Fault{Reason::bad_header,
                 "another number of variables: compare the unit's list with the configured one"};
  }

  Sentence read;
  read.checksum = opened->checksum;
  read.frame.stable = settled;
  read.frame.token = layout.token;
  read.frame.size = layout.variables.size();
  for (std::size_t i = 0; i < read.frame.size; ++i) {
    const VariableFacts& facts = layout.variables[i];
    const std::optional<double> value = sentence::number(sentence::take_field(rest));
    if (!value) return Fault{Reason::bad_value, "a field of the sentence is no number"};
    // A counter of 32 bits, with or without a sign.
    if (facts.type == ValueType::i32 && !(std::abs(*value) < 0x1p32)) {
      return Fault{Reason::bad_value, "a whole number of the sentence has more than 32 bits"};
    }
    read.frame.values[i] = *value * unit_of(facts, layout);
    const Status plausible = check_plausible(facts, read.frame.values[i], layout.limits);
    if (!plausible) return plausible.fault();
  }
  return read;
}

Result<Bytes> encode(const Frame& frame, const Layout& layout, MutableBytes to) noexcept {
  sentence::Writer writer{to};
  writer.put(frame.stable ? kSettled : kUnsettled);
  constexpr std::string_view kDigits = "0123456789";
  for (const unsigned place : {100U, 10U, 1U}) writer.put(kDigits.substr(layout.token / place % 10, 1));
  for (std::size_t i = 0; i < layout.variables.size(); ++i) {
    const VariableFacts& facts = layout.variables[i];
    writer.put(",");
    writer.put(frame.values[i] / unit_of(facts, layout), facts.type == ValueType::i32 ? 0
                                                         : layout.text_in_degrees     ? kDecimalsOfDegrees
                                                                                      : kDecimalsOfRadians);
  }
  return writer.finish();
}

}  // namespace motionlab::mru::nmeap
