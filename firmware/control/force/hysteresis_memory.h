// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>

#include "firmware/control/parameters/parameters.h"
#include "firmware/friction/memory_stack.h"
#include "firmware/friction/virgin_curves.h"

namespace slipstack {

/// The virgin curve of the target's elements.
using TargetCurve = PiecewiseLinearCurve<kTargetElements, float>;

/// The virgin curve that the model's elements make together, over displacement in steps of
/// `metres_per_step`; no knots without hysteresis. Slip distances are rounded as the tick's are. Outside the
/// tick.
inline TargetCurve virgin_curve_of(const ModelParameters& model, float metres_per_step) {
  const auto& own = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  constexpr auto kMost = static_cast<float>(PackedMaxwellSlip<kTargetElements>::kLargestSlipDistance);
  std::array<float, kTargetElements> knots{};
  std::array<float, kTargetElements> slopes{};
  std::size_t size = 0;
  for (std::size_t i = 0; i < own.shapes.size() && own.enabled; ++i) {
    const float steps = approx::clamp(own.shapes[i] / metres_per_step + 0.5F, 0.0F, kMost);
    const auto knot = static_cast<float>(static_cast<std::int32_t>(steps));
    const float stiffness = own.gains[i] * metres_per_step;
    if (!(knot > 0.0F) || !(stiffness > 0.0F)) continue;
    std::size_t place = 0;
    while (place < size && knots[place] < knot) ++place;
    if (place == size || knots[place] != knot) {
      for (std::size_t j = size; j > place; --j) {
        knots[j] = knots[j - 1];
        slopes[j] = slopes[j - 1];
      }
      knots[place] = knot;
      slopes[place] = 0.0F;
      ++size;
    }
    slopes[place] += stiffness;
  }
  // An element pulls with its stiffness up to its slip distance: an interval has the sum of those beyond.
  for (std::size_t j = size; j-- > 1;) slopes[j - 1] += slopes[j];
  TargetCurve curve;
  // Refused is only what the bounds of the parameters exclude; no knots then.
  if (curve.set_slopes(std::span(knots).first(size), std::span(slopes).first(size)) != SetupStatus::kOk) {
    return {};
  }
  return curve;
}

/// What of its motion the hysteresis remembers: the reversal points that are not wiped out yet, as a memory
/// stack that follows the same displacement as the tick's elements do. Runs in the main loop, from the last
/// points of the reference, which the tick keeps anyway: it costs the tick nothing.
class HysteresisMemory {
 public:
  static constexpr std::size_t kDepth = 16;

  /// New parameters: the same motion with another curve. `same_steps`: displacement keeps its unit; the
  /// motion is forgotten otherwise.
  void take(const TargetCurve& curve, bool same_steps) {
    stack_.set_curve(curve);
    active_ = curve.size() > 0;
    started_ = started_ && active_ && same_steps;
  }

  /// The displacement of the next tick.
  void step(std::int32_t displacement) {
    if (!active_) return;
    if (!started_) stack_.reset(displacement);
    started_ = true;
    stack_.step(displacement);
  }

  /// Ticks that the main loop was too late for.
  void miss(std::uint32_t ticks) { missed_ += ticks; }

  /// Reversal points held; 0 on the virgin curve and without hysteresis.
  std::uint32_t depth() const { return started_ ? static_cast<std::uint32_t>(stack_.depth()) : 0U; }
  /// Loops that gave way to a full stack since the start.
  std::uint32_t overflow_count() const { return stack_.overflow_count(); }
  /// Height of the highest of them, N.
  float overflow_height_N() const { return stack_.overflow_height_N(); }
  std::uint32_t missed_ticks() const { return missed_; }
  /// Force of the stack, N: that of the tick's elements at level 1 while nothing overflowed or was missed.
  float force_N() const { return started_ ? stack_.force_N() : 0.0F; }

 private:
  MemoryStack<TargetCurve, kDepth, std::int32_t> stack_{TargetCurve{}};
  bool active_ = false;
  bool started_ = false;
  std::uint32_t missed_ = 0;
};

}  // namespace slipstack
