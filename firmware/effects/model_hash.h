// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <tuple>

#include "firmware/effects/model.h"

namespace slipstack {

/// What identifies a set of parameters: the controller reports it, the model file carries it. FNV-1a (Fowler,
/// Noll, Vo) over the enabled effects' places in the catalogue, their shapes and gains as IEEE float bits.
/// Not a protection against intent, only against mix-ups. Cost: 4 products a parameter; not for the tick.
template <class... Effects>
constexpr std::uint32_t model_hash(const std::tuple<EffectParameters<Effects, float>...>& parameters) {
  std::uint32_t hash = 2166136261u;
  const auto take = [&hash](std::uint32_t word) {
    for (int byte = 0; byte < 4; ++byte) {
      hash = (hash ^ (word & 0xFFu)) * 16777619u;
      word >>= 8;
    }
  };
  std::uint32_t place = 0;
  std::apply(
      [&](const auto&... own) {
        const auto visit = [&](const auto& one) {
          ++place;
          if (!one.enabled) return;
          take(place);
          // Adding zero makes the two zeros one.
          for (const float shape : one.shapes) take(std::bit_cast<std::uint32_t>(shape + 0.0f));
          for (const float gain : one.gains) take(std::bit_cast<std::uint32_t>(gain + 0.0f));
        };
        (visit(own), ...);
      },
      parameters);
  return hash;
}

}  // namespace slipstack
