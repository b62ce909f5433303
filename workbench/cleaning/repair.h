// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/base/interval.h"
#include "workbench/cleaning/encoder_jumps.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// The faults that were found in a log.
struct Repairs {
  std::vector<Interval> cut;       ///< samples to be left out of every fit; ascending, disjoint
  std::vector<EncoderJump> jumps;  ///< of the encoder, ascending
  std::vector<Interval>
      impacts;  ///< pulses of the force that the drive causes (are_impacts()); they are kept
  std::vector<std::string> notes;  ///< one sentence for each kind of fault: what, how much, where first
};

/// Finds faults that only a recorder or a sensor can cause, and repairs those whose true values follow from
/// the neighbouring samples:
/// - outliers of force or position, up to three in a row: interpolated. Many close together are a burst,
///   caused by the axis or its surroundings, and are kept; so is a pulse of the force that moved the axis,
///   and so are impacts of the drive, which are reported.
/// - a force that is recorded at a lower rate than the position: noted with its delay, or refused (for a
///   position at a lower rate see held_position.h).
/// - samples that repeat the one before, where noise makes that impossible: interpolated.
/// - force at its limit, or frozen without its noise (drive off, sensor lost): cut. Not at standstill in a
///   log whose force has no noise there, and nowhere in one whose header says `current_source: commanded`.
/// - jumps of the encoder while the axis moves on: corrected, and reported in `jumps`, since positions are
///   uncertain in such a log. In a chunk of a log they are reported only, because a correction would shift
///   this chunk against the others.
/// - an encoder that stands still and then jumps to the true position: cut.
/// - motion without any force, as when the axis is moved by hand with the drive off: cut.
///
/// A log without such faults is not changed. Throws InputError where the faults cover so much of the log that
/// the rest would mislead; a chunk of a longer log is cut entirely instead. O(n).
enum class RepairScope { whole_log, chunk };
Repairs repair(Log& log, RepairScope scope = RepairScope::whole_log);

}  // namespace slipstack::workbench
