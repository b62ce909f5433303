// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/drive_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "firmware/control/supervision/faults.h"

namespace slipstack::workbench {
namespace {

struct FaultWords {
  Fault fault;
  const char* words;
};

constexpr std::array<FaultWords, kFaultCount - 1> kFaults{{
    {Fault::kEncoderLoss, "the encoder has lost its signal; check its cable and its supply"},
    {Fault::kEncoderJump, "the encoder jumped further than the axis can; check its shield and the scale"},
    {Fault::kStall,
     "motor blocked: current, and the axis stands; look for what is in its way, or for a brake"},
    {Fault::kFollowingError, "the axis does not follow its reference; look at load, limits and feedback"},
    {Fault::kOverCurrent, "the measured current is beyond its limit; check the amplifier and its wiring"},
    {Fault::kCurrentSensor, "the measured current is not the one that was asked for; check its sensor"},
    {Fault::kTickOverrun, "a tick took longer than its period"},
    {Fault::kWatchdog, "the watchdog has started the controller anew"},
    {Fault::kParameter, "parameters that are refused were written while the axis was enabled"},
    {Fault::kNotFinite, "a force was not a number; look at the parameters that were written last"},
    {Fault::kStopTimeout, "a controlled stop did not come to rest in time"},
    {Fault::kSetPoint, "there is no way to the target within the limits of the axis"},
    {Fault::kAmplifierFault, "the amplifier reports a fault; see its own display"},
    {Fault::kAmplifierNotReady, "the amplifier is not ready; check its supply and safe torque off"},
    {Fault::kOverspeed, "faster than the axis may ever be; check encoder and feedback"},
    {Fault::kIndexOffPlace, "a reference mark passed where none is: counts were lost or added"},
    {Fault::kOverload, "the motor has carried too much current for too long (I2t); let it cool down"},
    {Fault::kDirection, "a push moved the axis the wrong way: the encoder or the motor is reversed"},
    {Fault::kConnection, "the master was lost; write the controlword again"},
    {Fault::kEncoderStands,
     "a force that must move the axis, and an encoder that does not; check the encoder"},
    {Fault::kOverTemperature, "the motor is too hot"},
    {Fault::kAnalogueSensor, "a wire of an analogue sensor is broken"},
    {Fault::kUnderVoltage, "the voltage of the DC link is too low; check the motor supply"},
    {Fault::kOverVoltage, "the voltage of the DC link is too high: braking feeds it; brake more slowly"},
}};

struct CodeWords {
  std::uint16_t code;
  const char* words;
};

/// Of what does not stop the axis (docs/can.md), beside the drive's faults: communication, hunting.
constexpr std::array<CodeWords, 10> kOthers{{
    {0x8110, "frames of the bus were lost"},
    {0x8120, "the bus is disturbed (error passive); check termination, bit rate and cable"},
    {0x8130, "the heartbeat of another node is missing"},
    {0x8140, "back after the bus was off; check termination, bit rate and cable"},
    {0x8150, "another node sends with this node's identifiers; give one of them another id"},
    {0x8210, "a PDO came that is too short; it was not used"},
    {0x8220, "a PDO came that is too long"},
    {0x8240, "SYNC came with another length than 1019h says"},
    {0x8250, "a PDO did not come in time (1400h:05)"},
    {0xFF01, "the axis hunts; 2202h says what it comes from"},
}};

}  // namespace

std::string state_name(std::uint32_t word) {
  switch (word & 0x6F) {
    case 0x21:
      return "ready to switch on";
    case 0x23:
      return "switched on";
    case 0x27:
      return "operation enabled";
    case 0x07:
      return "quick stop active";
    default:
      break;
  }
  switch (word & 0x4F) {
    case 0x40:
      return "switch on disabled";
    case 0x0F:
      return "fault reaction active";
    case 0x08:
      return "fault";
    default:
      return "not ready to switch on";
  }
}

std::string mode_name(int mode) {
  switch (mode) {
    case 0:
      return "no mode";
    case 1:
      return "profile position";
    case 3:
      return "profile velocity";
    case 6:
      return "homing";
    case 8:
      return "cyclic synchronous position";
    case 9:
      return "cyclic synchronous velocity";
    case 10:
      return "cyclic synchronous torque";
    default:
      return fmt::format("mode {}", mode);
  }
}

std::string hunting_words(std::uint32_t state, std::uint32_t cause) {
  switch (state) {
    case 1:
      return "the axis hunts, and what it comes from is being tried";
    case 2:
      return cause == 2
                 ? "the disturbance observer made the axis hunt and is lowered; check motor constant, mass "
                   "and the observer's bandwidth, then write 1 to 2202h:09"
                 : "the friction compensation made the axis hunt and is lowered; the friction is less than "
                   "the model's: fit it anew, or write 1 to 2202h:09";
    case 3:
      return "the axis hunts, and not by its compensation; lower its gains, or look for a vibration from "
             "outside";
    default:
      break;
  }
  return cause == 4 ? "none now; the last one ended by itself" : "none";
}

std::string error_words(std::uint16_t code) {
  if (code == 0) return "no error";
  const auto fault = std::find_if(kFaults.begin(), kFaults.end(),
                                  [code](const FaultWords& one) { return error_code(one.fault) == code; });
  if (fault != kFaults.end()) return fault->words;
  const auto other =
      std::find_if(kOthers.begin(), kOthers.end(), [code](const CodeWords& one) { return one.code == code; });
  return other != kOthers.end() ? other->words : "unknown to this program";
}

}  // namespace slipstack::workbench
