// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/base/interval.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// Whether the pulses of the force are impacts of the drive: where there is play, a flank is hit after each
/// change of sign of the force (Nordin and Gutman 2002, section 2). A disturbance of the sensor does not know
/// when that is. More than half of the pulses are then in the tenth of the time that is nearest to changes of
/// sign, where by chance a tenth of them would be. False for fewer than five pulses. O(n).
bool are_impacts(const Log& log, const std::vector<Interval>& pulses);

}  // namespace slipstack::workbench
