// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/tracking_error.h"

#include <algorithm>
#include <cmath>

#include "firmware/canopen/objects/device_objects.h"
#include "workbench/controller/drive_access.h"
#include "workbench/controller/trace_data.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

constexpr std::uint32_t kDecimation = 5;             // 4096 samples at 10 kHz are two seconds
constexpr double kTurn = 0.45;                       // share of the trace after which the axis is sent back
constexpr int kMostPolls = 20'000;                   // each takes a tick or more
constexpr std::uint32_t kTargetReached = 1U << 10U;  // 6041h (CiA 402)

void enable(SdoClient& drive) {
  drive.write(0x6060, 0, 1, 1);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) drive.write(0x6040, 0, word, 2);
  for (int poll = 0; !is_enabled(drive); ++poll) {
    if (poll > kMostPolls) drive.fail("cannot be enabled; see its status");
  }
}

/// A set-point that takes effect at once.
void move_to(SdoClient& drive, std::int64_t target) {
  drive.write(0x607A, 0, static_cast<std::uint32_t>(target), 4);
  drive.write(0x6040, 0, 0x3F, 2);
  drive.write(0x6040, 0, 0x2F, 2);
}

}  // namespace

TrackingError record_tracking_error(SdoClient& drive, double travel_m, const Show& show) {
  const double resolution_m = drive.read_real(kAxisIndex, 1);
  if (!(resolution_m > 0.0)) drive.fail("2000h:01 is no resolution; is it commissioned?");
  enable(drive);
  const auto begin = static_cast<std::int32_t>(drive.read(0x6064, 0));
  const std::int64_t away = begin + std::llround(travel_m / resolution_m);
  drive.write(kTraceIndex, 1, 0, 1);
  drive.write(kTraceIndex, 3, kDecimation, 2);
  drive.write(kTraceIndex, 4, 0, 1);
  drive.write(kTraceIndex, 7, 0, 2);
  drive.write(kTraceIndex, 10, 0, 1);
  move_to(drive, away);
  drive.write(kTraceIndex, 1, 1, 1);
  bool back = false;
  const TraceData trace = fetch_trace(drive, [&](const std::string& stage, double fraction) {
    show(stage, fraction);
    if (back || fraction < kTurn) return;
    back = true;
    move_to(drive, begin);
  });
  for (int poll = 0; (drive.read(0x6041, 0) & kTargetReached) == 0; ++poll) {
    if (poll > kMostPolls) break;  // it is disabled where it stands
  }
  drive.write(0x6040, 0, 0x06, 2);

  TrackingError found;
  double squares = 0.0;
  const double step_s = static_cast<double>(trace.head.tick_s) * trace.head.decimation;
  for (const TraceSample& sample : trace.samples) {
    const double error_m = (sample.reference - sample.counts) * resolution_m;
    found.time_s.push_back(static_cast<double>(found.time_s.size()) * step_s);
    found.reference_m.push_back((sample.reference - trace.samples.front().reference) * resolution_m);
    found.error_m.push_back(error_m);
    squares += error_m * error_m;
    found.largest_m = std::max(found.largest_m, std::abs(error_m));
  }
  if (!found.error_m.empty()) found.rms_m = std::sqrt(squares / static_cast<double>(found.error_m.size()));
  return found;
}

}  // namespace slipstack::workbench
