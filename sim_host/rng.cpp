// SPDX-License-Identifier: Apache-2.0
#include "sim_host/rng.h"

#include <cmath>

namespace slipstack::sim {
namespace {

// SplitMix64 finaliser (Steele, Lea, Flood 2014): neighbouring seeds give unrelated streams.
std::uint64_t mix(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}

std::uint64_t stream_seed(std::uint64_t seed, std::string_view stream) {
  std::uint64_t state = mix(seed);
  for (const char letter : stream) state = mix(state ^ static_cast<unsigned char>(letter));
  return state;
}

}  // namespace

Rng::Rng(std::uint64_t seed, std::string_view stream) : engine_(stream_seed(seed, stream)) {}

double Rng::uniform() {
  return static_cast<double>(engine_() >> 11) * 0x1.0p-53;
}

double Rng::uniform(double low, double high) {
  return low + (high - low) * uniform();
}

double Rng::log_uniform(double low, double high) {
  return low * std::exp(uniform() * std::log(high / low));
}

double Rng::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  double u = 0.0;
  double v = 0.0;
  double square = 0.0;
  do {
    u = uniform(-1.0, 1.0);
    v = uniform(-1.0, 1.0);
    square = u * u + v * v;
  } while (square >= 1.0 || square == 0.0);
  const double factor = std::sqrt(-2.0 * std::log(square) / square);
  spare_normal_ = v * factor;
  has_spare_ = true;
  return u * factor;
}

std::size_t Rng::below(std::size_t count) {
  return static_cast<std::size_t>(uniform() * static_cast<double>(count));
}

}  // namespace slipstack::sim
