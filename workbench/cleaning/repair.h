// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/base/interval.h"
#include "workbench/cleaning/encoder_jumps.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// What a log's own faults leave to do.
struct Repairs {
  std::vector<Interval> cut;       ///< not to be compared with any model; ascending, apart
  std::vector<EncoderJump> jumps;  ///< of the encoder, ascending
  std::vector<std::string> notes;  ///< one sentence for each kind of fault: what, how much, where first
};

/// Finds what no axis does and only a recorder can, and mends it where neighbours tell what was there:
/// - wild samples of force or position among good ones, up to three in a row: interpolated. Many close
///   together are a burst, an event of the axis or its surroundings, and stay.
/// - samples that repeat the one before, where noise makes that impossible: interpolated.
/// - force at its limit, or frozen (drive off, sensor lost), while its noise is gone: cut. Not at rest in a
///   log whose force has no noise at rest, as a commanded current.
/// - an encoder that jumps while the axis does not: taken back, and told (`jumps`), since no position of
///   the log is sure then. Of a piece only told: other pieces of the log know nothing of it.
/// - an encoder that stands still and then jumps to where it should be: cut.
/// - motion without any force, as by hand with the drive off: cut.
///
/// Nothing is changed in a log without such faults. Throws InputError where they fill so much of the log that
/// what is left would mislead; of `a piece` of a longer log, all of it is cut then. O(n).
enum class RepairScope { whole_log, piece };
Repairs repair(Log& log, RepairScope what = RepairScope::whole_log);

}  // namespace slipstack::workbench
