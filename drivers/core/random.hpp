/// @file  A deterministic random source for simulators: the same seed gives the same bits on every machine.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace motionlab {

/// SplitMix64 (Steele, Lea, Flood 2014): fills the state of a larger generator from one number.
[[nodiscard]] constexpr std::uint64_t split_mix(std::uint64_t& state) noexcept {
  state += 0x9e3779b97f4a7c15;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

/// xoshiro256++ (Blackman, Vigna 2019) with the distributions that a simulator needs.
///
/// Standard distributions and `std::log` differ between libraries, so both are written here in operations
/// that IEEE 754 rounds exactly. Give every noise source a stream of its own: then adding a sensor changes
/// nobody else's noise.
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept {
    for (auto& word : state_) word = split_mix(seed);
  }
  /// The stream of this name under the seed, e.g. Random(seed, "mru1/heave").
  Random(std::uint64_t seed, std::string_view stream) noexcept : Random(seed ^ hash(stream)) {}

  /// 64 random bits.
  [[nodiscard]] std::uint64_t bits() noexcept {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  [[nodiscard]] double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }
  /// A whole number in [0, n). @pre n > 0. The bias is below n / 2^32.
  [[nodiscard]] std::uint32_t below(std::uint32_t n) noexcept {
    return static_cast<std::uint32_t>(((bits() >> 32) * n) >> 32);
  }
  /// True with this probability. 0 and 1 are certain.
  [[nodiscard]] bool chance(double probability) noexcept { return uniform() < probability; }

  /// Normal with mean 0 and standard deviation 1 (Marsaglia's polar method; every second one is free).
  [[nodiscard]] double normal() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double u = 0.0;
    double v = 0.0;
    double s = 0.0;
    do {
      u = 2.0 * uniform() - 1.0;
      v = 2.0 * uniform() - 1.0;
      s = u * u + v * v;
    } while (s >= 1.0 || s == 0.0);
    const double scale = std::sqrt(-2.0 * log_of(s) / s);
    spare_ = v * scale;
    has_spare_ = true;
    return u * scale;
  }

  /// Exponential with this mean.
  [[nodiscard]] double exponential(double mean) noexcept { return -mean * log_of(1.0 - uniform()); }

 private:
  /// FNV-1a.
  static constexpr std::uint64_t hash(std::string_view text) noexcept {
    std::uint64_t h = 0xcbf29ce484222325;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return h;
  }

  /// The natural logarithm of a normal x > 0, to about 2 ulp: 2 artanh((m - 1) / (m + 1)) + e ln 2.
  static double log_of(double x) noexcept {
    int exponent = 0;
    double m = std::frexp(x, &exponent);
    if (m < 0.70710678118654752) {
      m *= 2.0;
      --exponent;
    }
    const double s = (m - 1.0) / (m + 1.0);
    const double s2 = s * s;
    double series = 0.0;
    for (int k = 21; k >= 1; k -= 2) series = series * s2 + 1.0 / k;
    return 2.0 * s * series + exponent * 0.69314718055994531;
  }

  std::array<std::uint64_t, 4> state_{};
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace motionlab
