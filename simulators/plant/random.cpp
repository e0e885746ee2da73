#include "simulators/plant/random.hpp"

#include <bit>
#include <cmath>

namespace motionlab::plant {

Random::Random(std::uint64_t seed, std::string_view stream) {
  std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a of the stream's name
  for (const char c : stream) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  std::uint64_t x = seed ^ hash;
  for (auto& word : s_) {  // splitmix64
    x += 0x9e3779b97f4a7c15U;
    std::uint64_t z = x;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    word = z ^ (z >> 31U);
  }
}

std::uint64_t Random::next() {
  const std::uint64_t result = std::rotl(s_[0] + s_[3], 23) + s_[0];
  const std::uint64_t t = s_[1] << 17U;
  s_[2] ^= s_[0];
  s_[3] ^= s_[1];
  s_[1] ^= s_[2];
  s_[0] ^= s_[3];
  s_[2] ^= t;
  s_[3] = std::rotl(s_[3], 45);
  return result;
}

double Random::uniform() {
  return static_cast<double>(next() >> 11U) * 0x1.0p-53;
}

double Random::gaussian() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Marsaglia's polar method: two numbers at a time.
  double u, v, s;
  do {
    u = 2 * uniform() - 1;
    v = 2 * uniform() - 1;
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double m = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * m;
  has_spare_ = true;
  return u * m;
}

Eigen::Vector3d Random::gaussian3() {
  const double x = gaussian(), y = gaussian(), z = gaussian();
  return {x, y, z};
}

Eigen::Vector3d Random::direction() {
  return gaussian3().normalized();
}

GaussMarkov::GaussMarkov(double rms, double correlation_s, double step_s, Random& random)
    : keep_(std::exp(-step_s / correlation_s)),
      add_(rms * std::sqrt(1 - keep_ * keep_)),
      value_(rms * random.gaussian()) {}

double GaussMarkov::step(Random& random) {
  value_ = keep_ * value_ + add_ * random.gaussian();
  return value_;
}

}  // namespace motionlab::plant
