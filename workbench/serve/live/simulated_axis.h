// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "workbench/can/client/can_link.h"

namespace slipstack::workbench {

class SimulatedBus;

/// The axis to try things on where there is no hardware: that of `slipstack-sim log --setup`.
struct SimulatedAxis {
  std::uint64_t seed = 1;
  std::string effects = "random";        ///< names with commas, none, or random: one that the seed draws
  double strength = 0.0;                 ///< over the noise floor; 0: drawn
  double seconds = 30.0;                 ///< of the usual programme
  std::string setup = "pick_and_place";  ///< or random: mass, encoder, stroke and friction are drawn too
};

/// A measurement of the axis as CSV: along the usual test programme, or along a file of set points. Throws
/// UsageError for an unknown effect, and for set points outside the stroke.
std::string record_simulated_axis(const SimulatedAxis& axis, const std::string& set_points);

/// What is hidden in the axis: names with commas.
std::string hidden_in(const SimulatedAxis& axis);

/// The firmware's node around that axis, in this process, on a bus of which any number of masters may take a
/// link: each receives every frame of the node. The axis' time passes while one of them waits. The links may
/// be used by different threads and outlive this.
class SimulatedController {
 public:
  /// How long a master waits: as long as it says, or only as long as the simulation takes.
  enum class Wait : std::uint8_t { real_time, as_fast_as_possible };

  explicit SimulatedController(const SimulatedAxis& axis);
  ~SimulatedController();
  SimulatedController(const SimulatedController&) = delete;
  SimulatedController& operator=(const SimulatedController&) = delete;
  std::unique_ptr<CanLink> connect(Wait wait);

 private:
  std::shared_ptr<SimulatedBus> bus_;
};

}  // namespace slipstack::workbench
