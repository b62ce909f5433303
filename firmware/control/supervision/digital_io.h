// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

inline constexpr std::uint8_t kTerminals = 16;

/// Which terminal does what: 1 to kTerminals, 0 for none. As delivered nothing is wired.
struct IoParameters {
  std::uint8_t negative_limit = 0;
  std::uint8_t positive_limit = 0;
  std::uint8_t home_switch = 0;
  std::uint8_t amplifier_ready = 0;
  std::uint8_t amplifier_fault = 0;
  std::uint8_t brake = 0;              ///< output; active releases the brake
  std::uint16_t inverted_inputs = 0;   ///< bit 0: terminal 1 is active while low
  std::uint16_t inverted_outputs = 0;  ///< the same for outputs
};

/// Whether every function has a terminal that exists, or none. Two switches may be one, ready and fault may
/// not.
inline bool valid(const IoParameters& io) {
  for (const std::uint8_t terminal : {io.negative_limit, io.positive_limit, io.home_switch,
                                      io.amplifier_ready, io.amplifier_fault, io.brake}) {
    if (terminal > kTerminals) return false;
  }
  return io.amplifier_ready == 0 || io.amplifier_ready != io.amplifier_fault;
}

/// IoParameters in the form that the tick uses: one bit for each function, none where it is not wired.
struct IoMasks {
  std::uint32_t inverted_inputs = 0;
  std::uint32_t inverted_outputs = 0;
  std::uint32_t negative_limit = 0;
  std::uint32_t positive_limit = 0;
  std::uint32_t limits = 0;  ///< both of them
  std::uint32_t home_switch = 0;
  std::uint32_t amplifier_ready = 0;
  std::uint32_t amplifier_fault = 0;
  std::uint32_t amplifier = 0;       ///< both of them
  std::uint32_t amplifier_well = 0;  ///< their levels while the amplifier is ready and has no fault
  std::uint32_t brake = 0;

  static IoMasks of(const IoParameters& io) {
    IoMasks masks;
    masks.inverted_inputs = io.inverted_inputs;
    masks.inverted_outputs = io.inverted_outputs;
    masks.negative_limit = bit(io.negative_limit);
    masks.positive_limit = bit(io.positive_limit);
    masks.limits = masks.negative_limit | masks.positive_limit;
    masks.home_switch = bit(io.home_switch);
    masks.amplifier_ready = bit(io.amplifier_ready);
    masks.amplifier_fault = bit(io.amplifier_fault);
    masks.amplifier = masks.amplifier_ready | masks.amplifier_fault;
    masks.amplifier_well = (masks.amplifier_ready ^ masks.inverted_inputs) & masks.amplifier;
    masks.brake = bit(io.brake);
    return masks;
  }

  /// Of a terminal, 1 to kTerminals; none for 0.
  static std::uint32_t bit(std::uint8_t terminal) { return terminal == 0 ? 0U : 1U << (terminal - 1U); }
};

/// The inputs of one tick, and what they mean. A switch that is not wired is never active, an amplifier that
/// reports nothing is ready and has no fault.
class DigitalInputs {
 public:
  DigitalInputs() = default;
  /// `levels` of the terminals.
  explicit DigitalInputs(std::uint32_t levels) : levels_(levels) {}

  bool negative_limit(const IoMasks& io) const { return (active(io) & io.negative_limit) != 0; }
  bool positive_limit(const IoMasks& io) const { return (active(io) & io.positive_limit) != 0; }
  /// Terminals of limit switches that are active.
  std::uint32_t limits(const IoMasks& io) const { return active(io) & io.limits; }
  bool home_switch(const IoMasks& io) const { return (active(io) & io.home_switch) != 0; }
  bool amplifier_ready(const IoMasks& io) const { return (~active(io) & io.amplifier_ready) == 0; }
  bool amplifier_fault(const IoMasks& io) const { return (active(io) & io.amplifier_fault) != 0; }
  /// Ready, and no fault.
  bool amplifier_well(const IoMasks& io) const { return ((levels_ ^ io.amplifier_well) & io.amplifier) == 0; }
  /// Active terminals, whatever their polarity; bit 0 is terminal 1.
  std::uint32_t active(const IoMasks& io) const { return levels_ ^ io.inverted_inputs; }
  /// 60FDh (IEC 61800-7-201): bit 0 negative limit, 1 positive limit, 2 home switch, 16 on terminal 1 on.
  std::uint32_t word(const IoMasks& io) const {
    return (negative_limit(io) ? 1U : 0U) | (positive_limit(io) ? 2U : 0U) | (home_switch(io) ? 4U : 0U) |
           (active(io) << 16U);
  }

 private:
  std::uint32_t levels_ = 0;
};

/// In 60FEh (IEC 61800-7-201): bit 0 sets the brake, bit 16 on are terminal 1 on.
inline constexpr std::uint32_t kSetBrake = 1U;

/// Levels of the outputs for what 60FEh asks. The brake is released while the drive `releases` it, unless
/// 60FEh sets it: no master releases it otherwise.
inline std::uint32_t output_levels(const IoMasks& io, std::uint32_t wanted, bool releases) {
  const bool released = releases && (wanted & kSetBrake) == 0;
  const std::uint32_t active = ((wanted >> 16U) & ~io.brake) | (released ? io.brake : 0U);
  return active ^ io.inverted_outputs;
}

}  // namespace slipstack
