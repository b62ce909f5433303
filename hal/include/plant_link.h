// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack {

/// Words that an emulated board and the simulated plant share, in the guest's PSRAM and a file that the host
/// maps. Lock-step: the host writes its words, then `host_sequence`; the guest runs one tick, writes its
/// words, then `guest_sequence` with the same number; the host goes on. Little-endian on both sides.
struct PlantLink {
  static constexpr std::uint32_t kMagic = 0x534C4B31;  // "SLK1"
  static constexpr std::uint32_t kGuestAddress = 0x21000000;
  static constexpr std::uint32_t kQuit = 0xFFFFFFFF;  ///< as control_word: the guest ends with status 0

  // Written by the host.
  volatile std::uint32_t host_sequence;
  volatile std::int32_t counts;
  volatile std::uint32_t encoder_valid;
  volatile std::uint32_t control_word;
  volatile std::uint32_t move_sequence;  ///< a change starts a move to move_counts
  volatile std::int32_t move_counts;
  volatile std::uint32_t parameter_sequence;  ///< a change takes the parameter block
  volatile std::uint32_t parameter_bytes;
  // Written by the guest.
  volatile std::uint32_t magic;
  volatile std::uint32_t guest_sequence;
  volatile float current_A;
  volatile std::uint32_t driving;
  volatile std::uint32_t state;
  volatile std::uint32_t fault;
  volatile std::int32_t reference_counts;
  volatile std::uint32_t reference_idle;
  volatile float feedforward_N;
  volatile float residual_N;
  volatile std::uint32_t model_hash;
  volatile std::uint32_t last_status;  ///< of the last move or parameter block; 0 is well

  std::array<std::byte, 2048> parameters;
};

}  // namespace slipstack
