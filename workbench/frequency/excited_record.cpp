// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/excited_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

[[noreturn]] void refuse_record(const std::string& name, const std::string& why) {
  throw InputError(fmt::format("{}: {}", printable(name), why));
}

bool varies(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [&](double value) { return value != values.front(); });
}

}  // namespace

void check(const ExcitedRecord& record, const std::string& name) {
  const std::size_t samples = record.position_m.size();
  if (!(record.tick_s > 0.0) || !std::isfinite(record.tick_s) || record.decimation == 0)
    refuse_record(name, "tick_s and decimation must be positive");
  if (record.period_samples < 8) refuse_record(name, "a period must have at least 8 samples");
  if (samples < 2 * record.period_samples)
    refuse_record(name, fmt::format("{} samples are less than two periods of {}; record longer", samples,
                                    record.period_samples));
  if (record.force_N.size() != samples || (!record.excitation.empty() && record.excitation.size() != samples))
    refuse_record(name, "columns of different length");
  if (record.lowest < 1 || record.lowest >= record.highest || 2 * record.highest >= record.period_samples)
    refuse_record(name, fmt::format("harmonics {} to {} of a period of {} samples cannot be seen",
                                    record.lowest, record.highest, record.period_samples));
  if (!varies(record.position_m)) refuse_record(name, "the axis did not move; excite it more strongly");
  if (!varies(record.force_N)) refuse_record(name, "the force does not change; was the drive enabled?");
}

}  // namespace slipstack::workbench
