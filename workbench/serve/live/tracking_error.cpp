// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/tracking_error.h"

#include <algorithm>
#include <cmath>

#include "firmware/canopen/objects/device_objects.h"
#include "workbench/can/drive/trace_data.h"
#include "workbench/serve/live/driven_axis.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

constexpr std::uint32_t kDecimation = 5;  // 4096 samples at 10 kHz are two seconds
constexpr double kTurn = 0.45;            // share of the trace after which the axis is sent back

}  // namespace

TrackingError record_tracking_error(SdoClient& drive, double travel_m, const Show& show) {
  DrivenAxis axis(drive);
  drive.write(kTraceIndex, 1, 0, 1);
  drive.write(kTraceIndex, 3, kDecimation, 2);
  drive.write(kTraceIndex, 4, 0, 1);
  drive.write(kTraceIndex, 7, 0, 2);
  drive.write(kTraceIndex, 10, 0, 1);
  axis.move_to(travel_m);
  drive.write(kTraceIndex, 1, 1, 1);
  bool back = false;
  const TraceData trace = fetch_trace(drive, [&](const std::string& stage, double fraction) {
    show(stage, fraction);
    if (back || fraction < kTurn) return;
    back = true;
    axis.move_to(0.0);
  });
  static_cast<void>(axis.arrives());  // where it does not, it is disabled where it stands

  TrackingError found;
  double squares = 0.0;
  const double step_s = static_cast<double>(trace.head.tick_s) * trace.head.decimation;
  for (const TraceSample& sample : trace.samples) {
    const double error_m = (sample.reference - sample.counts) * axis.resolution_m();
    found.time_s.push_back(static_cast<double>(found.time_s.size()) * step_s);
    found.reference_m.push_back((sample.reference - trace.samples.front().reference) * axis.resolution_m());
    found.error_m.push_back(error_m);
    squares += error_m * error_m;
    found.largest_m = std::max(found.largest_m, std::abs(error_m));
  }
  if (!found.error_m.empty()) found.rms_m = std::sqrt(squares / static_cast<double>(found.error_m.size()));
  return found;
}

}  // namespace slipstack::workbench
