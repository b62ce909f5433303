// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack {

/// Why the axis was stopped. An active Limit is no fault.
enum class Fault : std::uint8_t {
  kNone,
  kEncoderLoss,        ///< the encoder reports the loss of its signal
  kEncoderJump,        ///< more counts in a tick, or another velocity in the next one, than can be
  kStall,              ///< current, and an encoder that stands still
  kFollowingError,     ///< position away from the reference
  kOverCurrent,        ///< measured current beyond its limit
  kCurrentSensor,      ///< measurement missing, or away from the set-point for too long
  kTickOverrun,        ///< a tick began late or took longer than its period
  kWatchdog,           ///< the last reset came from the watchdog
  kParameter,          ///< refused parameters were written while the axis was enabled
  kNotFinite,          ///< a force that is not a number
  kStopTimeout,        ///< a controlled stop did not come to rest in time
  kSetPoint,           ///< a target that no trajectory within its limits can be computed for
  kAmplifierFault,     ///< the amplifier reports a fault
  kAmplifierNotReady,  ///< driven, and the amplifier is not ready
  kOverspeed,          ///< faster than the axis may ever be, by its encoder
  kIndexOffPlace,      ///< an index mark passed where none is: counts were lost or added
  kOverload,           ///< I2t of motor or amplifier is spent, and that is to be a fault
  kDirection,          ///< a push moved the axis the wrong way: encoder or motor is reversed
  kConnection,         ///< the master is lost, and that is to be a fault (6007h: 1)
  kEncoderStands,      ///< a force that must move the axis, and an encoder that does not
  kOverTemperature,    ///< of the motor
  kAnalogueSensor,     ///< a wired analogue input at a rail
  kUnderVoltage,       ///< driven, and the DC link is below its least voltage
  kOverVoltage,        ///< the DC link is above its largest: braking feeds it
  kCount
};

inline constexpr std::size_t kFaultCount = static_cast<std::size_t>(Fault::kCount);

/// The error code of a fault for object 603Fh and EMCY (CiA 301 table 26, IEC 61800-7-201 table 8).
constexpr std::uint16_t error_code(Fault fault) {
  constexpr std::array<std::uint16_t, kFaultCount> kCodes = {
      0x0000, 0x7305, 0x7306, 0x7121, 0x8611, 0x2310, 0x5210, 0x6101, 0x6010, 0x6320, 0x6102, 0x8612, 0x8600,
      0x5400, 0x5410, 0x8400, 0x7320, 0x2350, 0x8A00, 0x8100, 0x7310, 0x4310, 0x7300, 0x3220, 0x3210};
  return kCodes[static_cast<std::size_t>(fault)];
}

/// What a fault leaves to stop a moving axis with.
enum class FaultReaction : std::uint8_t {
  kRelease,    ///< no position, or no force that may be made: zero current and the brake, at once
  kBrake,      ///< the axis follows its reference, which brakes
  kBrakeAnew,  ///< it does not: braked from where it is and as it moves; a second time it is released
};

constexpr FaultReaction reaction_to(Fault fault) {
  switch (fault) {
    case Fault::kTickOverrun:
    case Fault::kParameter:
    case Fault::kSetPoint:
    case Fault::kIndexOffPlace:
    case Fault::kCurrentSensor:
    case Fault::kOverload:
    case Fault::kConnection:
    case Fault::kOverTemperature:
    case Fault::kAnalogueSensor:
    // An axis that is braked feeds the DC link. What is left too little to brake with does not follow, and is
    // released then.
    case Fault::kUnderVoltage:
      return FaultReaction::kBrake;
    // The encoder may be right and the force too small, or the amplifier gone: braking finds out.
    case Fault::kFollowingError:
    case Fault::kOverCurrent:
    case Fault::kOverspeed:
      return FaultReaction::kBrakeAnew;
    default:
      return FaultReaction::kRelease;
  }
}

/// Whether the counts may have lost their place on the rail.
constexpr bool loses_place(Fault fault) {
  return fault == Fault::kEncoderLoss || fault == Fault::kEncoderJump || fault == Fault::kEncoderStands ||
         fault == Fault::kIndexOffPlace;
}

/// What a reversed encoder or motor may have caused: its direction is to be proved again.
constexpr bool doubts_direction(Fault fault) {
  return fault == Fault::kEncoderLoss || fault == Fault::kEncoderJump || fault == Fault::kEncoderStands ||
         fault == Fault::kFollowingError || fault == Fault::kOverCurrent || fault == Fault::kOverspeed;
}

/// Faults seen since the start: the first one that is not yet reset, and how often each came up. Counts stop
/// at their largest value.
class FaultRecord {
 public:
  void note(Fault fault) {
    if (fault == Fault::kNone) return;
    std::uint16_t& count = counts_[static_cast<std::size_t>(fault)];
    if (count < 0xFFFF) ++count;
    if (latched_ == Fault::kNone) latched_ = fault;
    last_ = fault;
  }
  void reset() { latched_ = last_ = Fault::kNone; }
  Fault latched() const { return latched_; }
  /// Whether it is noted already, and what came after it is not another one.
  bool has(Fault fault) const { return fault == latched_ || fault == last_; }
  std::uint16_t count(Fault fault) const { return counts_[static_cast<std::size_t>(fault)]; }

 private:
  Fault latched_ = Fault::kNone;
  Fault last_ = Fault::kNone;
  std::array<std::uint16_t, kFaultCount> counts_{};
};

}  // namespace slipstack
