// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

// Slow models of hysteresis that share neither code nor method with the core: no stack, no play or stop
// operator.
namespace slipstack::test {

// y(x) = S0 (1 - e^(-x / l)), a concave curve that the core does not have: MemoryStack takes any.
template <std::floating_point Real>
struct ExponentialCurve {
  using Value = Real;
  Real height_N;
  Real length;

  Real force(Real x) const { return -height_N * std::expm1(-x / length); }
  ExponentialCurve doubled() const { return {2 * height_N, 2 * length}; }
  Real stiffness(Real x) const { return height_N / length * std::exp(-x / length); }
};

// Force by Rules I and II from the whole history of positions, searched again at every step for its dominant
// extrema: the farthest excursion ever, the farthest one the other way since then, and so on to the present
// (the memory sequence of the Preisach model; Mayergoyz, Mathematical Models of Hysteresis, 1991,
// section 1.2).
class FullHistoryModel {
 public:
  explicit FullHistoryModel(std::function<double(double)> virgin_curve) : y_(std::move(virgin_curve)) {}

  double step(double x) {
    history_.push_back(x);
    const std::size_t now = history_.size() - 1;
    std::size_t at = 0;
    for (std::size_t i = 0; i <= now; ++i) {
      const double excursion = history_[i] < 0 ? -history_[i] : history_[i];
      const double farthest = history_[at] < 0 ? -history_[at] : history_[at];
      if (excursion >= farthest) at = i;
    }
    bool upper = history_[at] > 0;
    double force = upper ? y_(history_[at]) : -y_(-history_[at]);
    reversals_ = 0;
    while (at != now) {
      std::size_t next = at + 1;
      for (std::size_t i = at + 1; i <= now; ++i) {
        if (upper ? history_[i] <= history_[next] : history_[i] >= history_[next]) next = i;
      }
      const double rise = 2 * y_((upper ? history_[at] - history_[next] : history_[next] - history_[at]) / 2);
      force += upper ? -rise : rise;
      at = next;
      upper = !upper;
      ++reversals_;
    }
    return force;
  }

  // Turning points that the present force depends on.
  std::size_t reversals() const { return reversals_; }

 private:
  std::function<double(double)> y_;
  std::vector<double> history_{0.0};
  std::size_t reversals_ = 0;
};

// One Maxwell-slip element on integer positions as a sum of two-state relays (Preisach): the anchor stands at
// the count of relays that are up. The relay between the places c and c + 1 goes up when x - Delta > c and
// down when x + Delta <= c.
class RelayElement {
 public:
  RelayElement(std::int32_t slip_distance, std::int32_t range)
      : slip_distance_(slip_distance), lowest_(-range), up_(static_cast<std::size_t>(2 * range), false) {
    for (std::int32_t c = lowest_; c < range; ++c) relay(c) = c < 0;
  }

  // Moves to x, abs(x) <= range; returns the displacement of the spring.
  std::int32_t step(std::int32_t x) {
    std::int32_t anchor = lowest_;
    for (std::int32_t c = lowest_; c < -lowest_; ++c) {
      if (x - slip_distance_ > c) relay(c) = true;
      if (x + slip_distance_ <= c) relay(c) = false;
      anchor += relay(c) ? 1 : 0;
    }
    return x - anchor;
  }

 private:
  std::vector<bool>::reference relay(std::int32_t c) { return up_[static_cast<std::size_t>(c - lowest_)]; }

  std::int32_t slip_distance_;
  std::int32_t lowest_;
  std::vector<bool> up_;
};

}  // namespace slipstack::test
