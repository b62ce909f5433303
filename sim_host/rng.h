// SPDX-License-Identifier: Apache-2.0
// Seeded random numbers that are the same with every standard library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <string_view>
#include <vector>

namespace slipstack::sim {

/// A stream of random numbers. The engine is the standard's (its output is specified bit by bit); the
/// distributions are implemented here, because those of the standard library differ between implementations.
///
/// Streams are named: the same seed gives independent streams for "axis", "motion", "noise", so that drawing
/// one number more in one of them does not change the others.
class Rng {
 public:
  explicit Rng(std::uint64_t seed, std::string_view stream = {});

  /// Uniform on [0, 1), 53 bits.
  double uniform();
  /// Uniform on [low, high).
  double uniform(double low, double high);
  /// Uniform in the logarithm on [low, high); both bounds positive.
  double log_uniform(double low, double high);
  /// Standard normal (Marsaglia's polar method).
  double normal();
  /// Uniform integer 0 … count−1; count > 0.
  std::size_t below(std::size_t count);
  /// True with the given probability.
  bool chance(double probability) { return uniform() < probability; }
  /// −1 or 1, either as likely.
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  /// One of the given values.
  template <typename T>
  T pick(std::initializer_list<T> values) {
    return *(values.begin() + below(values.size()));
  }
  template <typename T>
  T pick(const std::vector<T>& values) {
    return values[below(values.size())];
  }

 private:
  std::mt19937_64 engine_;
  double spare_normal_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace slipstack::sim
