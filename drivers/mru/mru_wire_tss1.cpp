#include "drivers/mru/mru_wire_tss1.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace motionlab::mru::tss1 {
namespace {

constexpr double kCentidegree = 0.01 * kDegree;
constexpr double kCentimetre = 0.01;
constexpr double kUpCount_mps2 = 0.000625;
constexpr int kMost = 9999;

/// A cursor over the characters that remembers whether one was out of place.
class Line {
 public:
  explicit Line(std::string_view text) noexcept : text_(text) {}

  void expect(char c) noexcept { good_ = next() == c && good_; }

  std::uint32_t hex(int digits) noexcept {
    std::uint32_t value = 0;
    for (int i = 0; i < digits; ++i) {
      const char c = next();
      if (c >= '0' && c <= '9')
        value = 16 * value + static_cast<std::uint32_t>(c - '0');
      else if (c >= 'A' && c <= 'F')
        value = 16 * value + static_cast<std::uint32_t>(c - 'A' + 10);
      else if (c >= 'a' && c <= 'f')
        value = 16 * value + static_cast<std::uint32_t>(c - 'a' + 10);
      else
        good_ = false;
    }
    return value;
  }

  /// A space or a minus, and four digits.
  std::int16_t signed_four() noexcept {
    const char sign = next();
    if (sign != ' ' && sign != '-') good_ = false;
    int value = 0;
    for (int i = 0; i < 4; ++i) {
      const char c = next();
      if (c < '0' || c > '9') good_ = false;
      value = 10 * value + (c - '0');
    }
    return good_ ? static_cast<std::int16_t>(sign == '-' ? -value : value) : std::int16_t{0};
  }

  char next() noexcept { return text_[position_++]; }
  void fail() noexcept { good_ = false; }
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  std::string_view text_;
  std::size_t position_ = 0;
  bool good_ = true;
};

constexpr char to_lower(char capital) noexcept {
  return static_cast<char>(capital - 'A' + 'a');
}

void read_status(Line& line, Frame& frame) noexcept {
  const char letter = line.next();
  for (const Aiding aiding : {Aiding::none, Aiding::speed, Aiding::heading, Aiding::full}) {
    const char capital = static_cast<char>(aiding);
    if (letter != capital && letter != to_lower(capital)) continue;
    frame.aiding = aiding;
    frame.settled = letter == capital;
    return;
  }
  line.fail();
}

class LineWriter {
 public:
  explicit LineWriter(MutableBytes to) noexcept : writer_(to) {}

  void put(char c) noexcept { writer_.write(static_cast<std::uint8_t>(c)); }
  void hex(std::uint32_t value, int digits) noexcept {
    for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) put("0123456789ABCDEF"[value >> shift & 0xF]);
  }
  void signed_four(int value) noexcept {
    const int shown = std::abs(value) > kMost ? kMost : value;
    put(shown < 0 ? '-' : ' ');
    for (int power = 1000; power > 0; power /= 10) {
      put(static_cast<char>('0' + std::abs(shown) / power % 10));
    }
  }

 private:
  LittleWriter writer_;
};

}  // namespace

Result<Frame> decode(Bytes bytes) noexcept {
  if (bytes.size() < kSize) return Fault{Reason::too_short, "shorter than the 27 characters of TSS1"};
  if (bytes.size() > kSize) return Fault{Reason::too_long, "longer than the 27 characters of TSS1"};
  Line line{as_text(bytes)};
  Frame frame;
  line.expect(':');
  frame.a_sway_counts = static_cast<std::uint8_t>(line.hex(2));
  frame.a_up_counts = static_cast<std::int16_t>(line.hex(4));
  line.expect(' ');
  frame.heave_up_cm = line.signed_four();
  read_status(line, frame);
  frame.roll_cdeg = line.signed_four();
  line.expect(' ');
  frame.pitch_cdeg = line.signed_four();
  line.expect('\r');
  line.expect('\n');
  if (!line.good()) {
    return Fault{Reason::bad_header, "a character is out of place: the port does not carry TSS1"};
  }
  return frame;
}

Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept {
  if (to.size() < kSize) return Fault{Reason::too_short, "no room for the line"};
  LineWriter line{to.first(kSize)};
  const char capital = static_cast<char>(frame.aiding);
  line.put(':');
  line.hex(frame.a_sway_counts, 2);
  line.hex(static_cast<std::uint16_t>(frame.a_up_counts), 4);
  line.put(' ');
  line.signed_four(frame.heave_up_cm);
  line.put(frame.settled ? capital : to_lower(capital));
  line.signed_four(frame.roll_cdeg);
  line.put(' ');
  line.signed_four(frame.pitch_cdeg);
  line.put('\r');
  line.put('\n');
  return Bytes{to.first(kSize)};
}

Motion motion_of(const Frame& frame) noexcept {
  Motion motion;
  motion.stable = frame.settled;
  const double pitch = kCentidegree * frame.pitch_cdeg;
  motion.euler_heading_mru_rad[0] = euler_roll(kCentidegree * frame.roll_cdeg, pitch);
  motion.euler_heading_mru_rad[1] = pitch;
  motion.p_heading_origin_m[2] = -kCentimetre * frame.heave_up_cm;
  motion.a_heading_origin_mps2[2] = -kUpCount_mps2 * frame.a_up_counts;
  return motion;
}

Frame frame_of(const Motion& motion) noexcept {
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  Frame frame;
  frame.a_up_counts = to_counts<std::int16_t>(-motion.a_heading_origin_mps2[2], kUpCount_mps2);
  frame.heave_up_cm = to_counts<std::int16_t>(-motion.p_heading_origin_m[2], kCentimetre);
  frame.settled = motion.stable;
  frame.roll_cdeg = to_counts<std::int16_t>(hippy_roll(roll, pitch), kCentidegree);
  frame.pitch_cdeg = to_counts<std::int16_t>(pitch, kCentidegree);
  return frame;
}

}  // namespace motionlab::mru::tss1
