// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/node_parts.h"

namespace slipstack::canopen {

/// The reaction to a heartbeat that fails to come and to bus-off: nobody holds the lock any more, the drive
/// reacts as 6007h says, and the node takes the state of its error behaviour 1029h:01 (CiA 301),
/// which is returned: 0 pre-operational if it was operational, 1 no change, 2 stopped.
inline NmtState react_to_lost_connection(NodeParts& parts, NmtState state) {
  parts.lock.close();
  parts.application.connection_lost();
  const std::uint32_t behaviour = parts.dictionary.value(kRow<0x1029, 1>);
  if (behaviour == 2) return NmtState::kStopped;
  return behaviour == 0 && state == NmtState::kOperational ? NmtState::kPreOperational : state;
}

}  // namespace slipstack::canopen
