// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/control/supervision/state_machine.h"

namespace slipstack::canopen {

/// How the axis stops, by the option codes 605Ah to 605Eh: bits of Command::word.
inline std::uint32_t stop_options(const Dictionary& dictionary) {
  const std::uint32_t quick_stop = dictionary.value(kRow<0x605A>);
  const std::uint32_t fault = dictionary.value(kRow<0x605E>);
  std::uint32_t options = 0;
  if (quick_stop >= 5) options |= kStayStopped;
  if (quick_stop == 1 || quick_stop == 5) options |= kSlowQuickStop;
  if (dictionary.value(kRow<0x605B>) == 1) options |= kBrakeOnShutdown;
  if (dictionary.value(kRow<0x605C>) == 1) options |= kBrakeOnDisable;
  if (dictionary.value(kRow<0x605D>) == 1) options |= kSlowHalt;
  if (fault == 0) options |= kReleaseOnFault;
  if (fault == 1) options |= kSlowFaultReaction;
  return options;
}

}  // namespace slipstack::canopen
