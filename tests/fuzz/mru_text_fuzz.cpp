// Any bytes as TSS1 and as sentences: each decoder survives, and what it accepts comes back with the same
// values when it is written and read again; what becomes a motion is plausible.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/mru/mru_wire_detect.hpp"
#include "drivers/mru/mru_wire_formats.hpp"
#include "drivers/mru/mru_wire_nmea.hpp"
#include "drivers/mru/mru_wire_nmeap.hpp"
#include "drivers/mru/mru_wire_tss1.hpp"

namespace {

using namespace motionlab;

void expect(bool condition) {
  if (!condition) std::abort();
}

void try_tss1(Bytes bytes) {
  const auto frame = mru::tss1::decode(bytes);
  if (!frame) return;
  std::array<std::uint8_t, mru::tss1::kSize> room{};
  expect(mru::tss1::encode(*frame, room).ok());
  const auto again = mru::tss1::decode(room);
  expect(again.ok());
  expect(again->a_sway_counts == frame->a_sway_counts && again->a_up_counts == frame->a_up_counts &&
         again->heave_up_cm == frame->heave_up_cm && again->aiding == frame->aiding &&
         again->settled == frame->settled && again->roll_cdeg == frame->roll_cdeg &&
         again->pitch_cdeg == frame->pitch_cdeg);
}

void try_sentence(Bytes bytes) {
  const auto sentence = mru::nmea::decode(as_text(bytes));
  if (!sentence || sentence->kind == mru::nmea::Kind::other) return;
  std::array<std::uint8_t, 1024> room{};
  const auto text = mru::nmea::encode(*sentence, room);
  if (!text || text->size() > mru::nmea::kMaxSentence) return;  // numbers of a hundred digits
  const auto again = mru::nmea::decode(as_text(*text));
  expect(again.ok() && again->kind == sentence->kind && again->checksum == mru::nmea::Checksum::good);
  for (std::size_t i = 0; i < mru::nmea::value_count(sentence->kind); ++i) {
    const double a = sentence->values[i], b = again->values[i];
    expect(std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= 0.5 + 1e-9 * std::abs(a));
  }
}

void try_nmeap(Bytes bytes) {
  static const mru::Layout layout = [] {
    constexpr std::array kList{mru::Variable::system_time, mru::Variable::roll, mru::Variable::pos_cg_d};
    return mru::Layout{.variables = mru::VariableList::of(kList).value(), .limits = {}};
  }();
  const auto read = mru::nmeap::decode(as_text(bytes), layout);
  if (!read) return;
  std::array<std::uint8_t, mru::nmeap::kMaxSentence> room{};
  const auto text = mru::nmeap::encode(read->frame, layout, room);
  expect(text.ok());
  const auto again = mru::nmeap::decode(as_text(*text), layout);
  expect(again.ok() && again->frame.stable == read->frame.stable);
  expect(std::abs(again->frame.values[0] - read->frame.values[0]) <= 0.5);
  for (std::size_t i = 1; i < 3; ++i)
    expect(std::abs(again->frame.values[i] - read->frame.values[i]) <= 0.51e-6);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes{data, size};
  try_tss1(bytes);
  try_sentence(bytes);
  try_nmeap(bytes);
  for (const auto format : {mru::Format::tss1, mru::Format::psxn, mru::Format::prdid}) {
    mru::Decoder decoder{format, {}};
    // Twice: the second time it remembers.
    for (int i = 0; i < 2; ++i) {
      const auto heard = decoder.decode(bytes);
      if (heard && *heard) expect(mru::check_plausible((*heard)->motion, {}).ok());
    }
  }
  mru::FormatDetector detector;
  detector.take(bytes);
  return 0;
}
