// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack::canopen {

/// One more, and no further than the counter reaches: a master that polls rarely still sees that it was many.
constexpr void count(std::uint32_t& counter) {
  if (counter < 0xFFFFFFFF) ++counter;
}

}  // namespace slipstack::canopen
