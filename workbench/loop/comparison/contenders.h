// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "workbench/loop/comparison/contender.h"

namespace slipstack::workbench {

/// Which of the contenders take part.
enum class Field {
  kAll,
  kFew,
  /// For an axis with effects beside mass and hysteresis: with slipstack's model as diagnosed, without the
  /// bounds, which know the friction alone.
  kWithEffects
};

/// What takes part, in the order of tuned_contenders().
std::vector<ContenderName> contenders_of(Field field);

/// The contenders for an axis, all with the same feedback (what `slipstack tune` proposes for its mass),
/// tuned on one training motion:
///   P/PI; with mass feed-forward; a table of 20 forces over velocity; Coulomb, Stribeck and viscous
///   friction; Dahl; LuGre; elasto-plastic; GMS; the disturbance observer with and without mass feed-forward;
///   iterative learning control over ten repetitions; slipstack's Maxwell-slip elements; the same with maps
///   of ripple and preload, with adaptation of level and mass, with the disturbance observer.
/// Behind them three bounds, which are no compensators: the friction of the simulated axis itself fed
/// forward; the same without noise of the force; the same with an encoder of a hundredth of the step,
/// 1 nm at least.
/// Friction models are fitted to a log of the training motion, by the drive with mass feed-forward
/// (fit_friction()), and then their level is searched in the loop, as are share and learning: Nelder-Mead by
/// NLopt, for the least rms error. slipstack's models are what `fit` makes of the same log, and are not
/// searched in the loop. kFew: P/PI, mass, the table and Maxwell-slip alone. kWithEffects: slipstack also
/// with the effects that `diagnose` finds in that log, alone and with the disturbance observer. Some 10 s of
/// a processor.
std::vector<Contender> tuned_contenders(const sim::Axis& axis, std::uint64_t seed, Field field,
                                        const std::function<void(double)>& progress);

}  // namespace slipstack::workbench
