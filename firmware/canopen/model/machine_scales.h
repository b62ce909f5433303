// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "hal/include/signal_scaling.h"

// The scales of the machine as they stand in the dictionary.
namespace slipstack::canopen {

inline SignalScales staged_scales(const Dictionary& dictionary) {
  return {dictionary.value(kRow<kScalesIndex, 1>) != 0, dictionary.value(kRow<kScalesIndex, 2>) != 0,
          dictionary.real(kRow<kScalesIndex, 3>),       dictionary.real(kRow<kScalesIndex, 4>),
          dictionary.real(kRow<kScalesIndex, 5>),       dictionary.real(kRow<kScalesIndex, 6>)};
}

/// What the check of the direction has been passed with: signs, scales, encoder, resolution and motor
/// constant, by FNV-1a. Never 0, which stands for no check.
inline std::uint32_t scales_hash(const Dictionary& dictionary) {
  constexpr std::array<std::size_t, 8> kRows = {
      kRow<kScalesIndex, 1>, kRow<kScalesIndex, 2>, kRow<kScalesIndex, 3>, kRow<kScalesIndex, 4>,
      kRow<kScalesIndex, 5>, kRow<kScalesIndex, 6>, kRow<kAxisIndex, 1>,   kRow<kAxisIndex, 3>};
  std::uint32_t hash = 2166136261U;
  const auto add = [&](std::size_t row) {
    for (unsigned shift = 0; shift < 32; shift += 8) {
      hash = (hash ^ (dictionary.value(row) >> shift & 0xFFU)) * 16777619U;
    }
  };
  for (const std::size_t row : kRows) add(row);
  // Of an incremental encoder there is nothing more to know.
  if (dictionary.value(kRow<kEncoderIndex, 1>) != 0) {
    for (const std::size_t row : {kRow<kEncoderIndex, 1>, kRow<kEncoderIndex, 2>, kRow<kEncoderIndex, 3>})
      add(row);
  }
  return hash != 0 ? hash : 1U;
}

}  // namespace slipstack::canopen
