// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/canopen/objects/communication_objects.h"
#include "firmware/canopen/objects/device_objects.h"
#include "firmware/canopen/objects/friction_objects.h"
#include "firmware/canopen/objects/machine_objects.h"
#include "firmware/canopen/objects/profile_objects.h"
#include "firmware/canopen/objects/program_objects.h"

// The object dictionary: every object once. The node serves it; canopen_files writes the EDS, the DBC and the
// reference page from it.
namespace slipstack::canopen {

namespace detail {

template <std::size_t... N>
constexpr auto joined(const std::array<Object, N>&... parts) {
  std::array<Object, (N + ...)> all{};
  std::size_t at = 0;
  const auto append = [&](const auto& part) {
    for (const Object& object : part) all[at++] = object;
  };
  (append(parts), ...);
  return all;
}

constexpr std::uint32_t key(std::uint16_t index, std::uint8_t sub) {
  return (static_cast<std::uint32_t>(index) << 8) | sub;
}

}  // namespace detail

inline constexpr auto kObjects = detail::joined(
    kCommunicationObjects, kReceivePdoObjects, kTransmitPdoObjects, kProgramRows, kAxisRows, kIoRows,
    kHomingRows, kReferenceRows, kTouchProbeRows, kEffectRows, kModelRows, kObserverRows, kByEffectRows,
    kHuntingRows, kTimingRows, kCounterRows, kFaultRows, kTraceRows, kExcitationRows, kLockRows, kNodeRows,
    kUpdateRows, kMachineRows, kProfileObjects, kHomingMethodRows, kLastProfileObjects);
inline constexpr std::size_t kObjectCount = kObjects.size();

static_assert(
    [] {
      for (std::size_t i = 1; i < kObjectCount; ++i) {
        const Object& before = kObjects[i - 1];
        const Object& object = kObjects[i];
        if (detail::key(before.index, before.sub) >= detail::key(object.index, object.sub)) return false;
      }
      return true;
    }(),
    "objects in ascending order, none twice");

inline constexpr std::size_t kNoRow = kObjectCount;

/// The row of an object, kNoRow if there is none: nine comparisons.
constexpr std::size_t find_row(std::uint16_t index, std::uint8_t sub) {
  const std::uint32_t wanted = detail::key(index, sub);
  std::size_t low = 0;
  std::size_t high = kObjectCount;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (detail::key(kObjects[middle].index, kObjects[middle].sub) < wanted) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < kObjectCount && detail::key(kObjects[low].index, kObjects[low].sub) == wanted ? low : kNoRow;
}

/// The row of an object that is known to be there; a mistyped one does not compile.
template <std::uint16_t kIndex, std::uint8_t kSub = 0>
inline constexpr std::size_t kRow = [] {
  constexpr std::size_t found = find_row(kIndex, kSub);
  static_assert(found != kNoRow);
  return found;
}();

/// Whether an index has any sub-index.
constexpr bool has_index(std::uint16_t index) {
  return find_row(index, 0) != kNoRow;
}

}  // namespace slipstack::canopen
