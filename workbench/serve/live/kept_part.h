// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "workbench/can/drive/drive_stream.h"

namespace slipstack::workbench {

/// Of a log at least: less has no stretch that a fit could hold out.
inline constexpr double kLeastRecording_s = 2.0;

bool is_long_enough(std::size_t samples, const StreamedAxis& axis);

/// The part of a recording that becomes a log: without a gap of more than ten samples (shorter ones are
/// interpolated), the longest of those in which the axis goes at least half as far as in any that is long
/// enough. A long rest is no measurement. O(n).
std::vector<StreamSample> part_to_keep(std::span<const StreamSample> samples, const StreamedAxis& axis);

}  // namespace slipstack::workbench
