// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack {

/// Words that a controller in lock-step and the simulated plant share: on an emulated board in the guest's
/// PSRAM and a file that the host maps, else in the memory of one process. The host writes its words, then
/// `host_sequence`; the controller serves what is asked, runs one tick, writes its words, then
/// `guest_sequence` with the same number; the host goes on. Little-endian on both sides, words only.
struct PlantLink {
  static constexpr std::uint32_t kMagic = 0x534C4B35;  // "SLK5"
  static constexpr std::uint32_t kQuit = 0xFFFFFFFF;   ///< as control_word: the guest ends with status 0
  static constexpr std::uint32_t kCommandedByBus = 0xFFFFFFFE;  ///< as control_word: the node alone commands
  static constexpr std::uint32_t kClockTicks_Hz = 10'000'000;
  static constexpr std::size_t kEffects = 24;
  static constexpr std::size_t kFaults = 32;
  static constexpr std::size_t kEdges = 16;

  // Written by the host.
  volatile std::uint32_t host_sequence;
  volatile std::uint32_t period;  ///< of a tick, in 1 / kClockTicks_Hz
  volatile std::uint32_t late;    ///< the next tick comes so much later, in the same unit
  volatile std::int32_t counts;
  volatile std::uint32_t encoder_valid;
  volatile std::uint32_t index_sequence;  ///< a change: an index mark passed at index_counts
  volatile std::int32_t index_counts;
  volatile std::uint32_t edge_terminal;  ///< whose edges are captured, 1 to 16; 0: none
  volatile std::uint32_t
      edge_sequence;                 ///< edges since the start; number n, from 1 on, is below at n % kEdges
  volatile std::uint32_t edge_high;  ///< the level behind the last one
  std::array<volatile std::int32_t, kEdges> edge_counts;
  volatile std::uint32_t current_valid;
  volatile std::uint32_t digital_inputs;  ///< levels, bit 0 is terminal 1
  volatile float current_offset_A;        ///< measured current less the one commanded
  volatile std::uint32_t analogue_valid;  ///< of the two below
  volatile float temperature_V;           ///< at the converter's pin
  volatile float bus_V;                   ///< likewise
  volatile std::uint32_t control_word;
  volatile std::uint32_t torque_mode;    ///< beside control_word; not 0: the axis follows target_N
  volatile float target_N;               ///< force in torque mode
  volatile std::uint32_t move_sequence;  ///< a change starts a move to move_counts
  volatile std::int32_t move_counts;
  volatile std::uint32_t stream_sequence;  ///< a change takes a set-point of the stream
  volatile std::int32_t stream_counts;
  volatile std::uint32_t stream_fraction;     ///< of a count, x 2^-32
  volatile std::uint32_t stream_period;       ///< ticks from one set-point to the next
  volatile std::uint32_t parameter_sequence;  ///< a change takes the parameter block
  volatile std::uint32_t parameter_bytes;
  // Written by the controller.
  volatile std::uint32_t magic;
  volatile std::uint32_t guest_sequence;
  volatile float current_A;
  volatile std::uint32_t driving;
  volatile std::uint32_t digital_outputs;  ///< levels, bit 0 is terminal 1
  volatile std::uint32_t state;
  volatile std::uint32_t fault;
  volatile std::uint32_t limits;
  volatile std::int32_t reference_counts;
  volatile std::uint32_t reference_idle;
  volatile std::uint32_t reference_underruns;
  volatile float position_error_m;
  volatile float velocity_mps;
  volatile float feedforward_N;
  volatile float feedback_N;
  volatile float residual_N;
  volatile float level;
  volatile std::uint32_t ticks;
  volatile std::uint32_t longest_period;  ///< between two ticks, in clock ticks
  volatile std::uint32_t longest_duration;
  volatile std::uint32_t overruns;
  volatile std::uint32_t watchdog_refreshed;
  volatile std::uint32_t memory_depth;     ///< loops that the hysteresis holds
  volatile std::uint32_t memory_overflow;  ///< loops that were too many to be followed
  volatile std::uint32_t model_hash;
  volatile std::uint32_t last_status;  ///< of the last move or parameter block; 0 is well
  volatile std::uint32_t stream_refused;
  std::array<volatile float, kEffects> by_effect_N;  ///< in the order of the catalogue
  std::array<volatile std::uint32_t, kFaults> fault_counts;

  std::array<std::byte, 2048> parameters;
};

/// What lies in the memory that an emulated board shares with the host: the link, and its flash pages.
struct PlantMemory {
  static constexpr std::size_t kFlashOffset = 0x10000;
  static constexpr std::size_t kFlashPages = 2;
  static constexpr std::size_t kFlashPageBytes = 2048;
  static constexpr std::size_t kBytes = 0x20000;
};
static_assert(sizeof(PlantLink) <= PlantMemory::kFlashOffset);

}  // namespace slipstack
