// SPDX-License-Identifier: Apache-2.0
// Logs of a drive on the bus: a stream of PDOs, or the drive's own trace buffer.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/can/commands/master.h"
#include "workbench/can/drive/drive_stream.h"
#include "workbench/can/drive/trace_data.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

/// The header of a log: the parameters of the axis that the drive holds.
std::string log_head(double resolution_m, double constant, double mass_kg, std::uint32_t hash, bool irregular,
                     std::size_t lost) {
  std::string text = fmt::format(
      "# encoder_resolution_m: {}\n# motor_constant_N_per_A: {}\n# mass_kg: {}\n# current_source: commanded\n"
      "# model_hash: {:08x}\n",
      resolution_m, constant, mass_kg, hash);
  if (lost > 0) text += fmt::format("# lost_samples: {}\n", lost);
  if (irregular) text += "# sampling: irregular\n";
  return text + "time_s,position_counts,current_A\n";
}

/// Takes as many samples of the stream as are wanted.
std::vector<StreamSample> take(SdoClient& drive, DriveStream& stream, std::size_t wanted, const Show& show) {
  std::vector<StreamSample> samples;
  samples.reserve(wanted);
  while (samples.size() < wanted) {
    const std::optional<StreamSample> sample = stream.next(1000);
    if (!sample) {
      drive.fail(
          fmt::format("the stream stopped after {} samples; is the drive still on the bus?", samples.size()));
    }
    samples.push_back(*sample);
    if (samples.size() % 64 == 0)
      show("record", static_cast<double>(samples.size()) / static_cast<double>(wanted));
  }
  return samples;
}

/// Spread of the arrival of frames against the drive's own clock; none without time stamps.
std::optional<double> arrival_spread_s(const std::vector<StreamSample>& samples, double tick_s) {
  double earliest_s = HUGE_VAL;
  double latest_s = -HUGE_VAL;
  for (const StreamSample& sample : samples) {
    if (sample.stamp_s == 0.0) return {};
    const double late_s = sample.stamp_s - samples.front().stamp_s -
                          static_cast<double>(sample.tick - samples.front().tick) * tick_s;
    earliest_s = std::min(earliest_s, late_s);
    latest_s = std::max(latest_s, late_s);
  }
  return latest_s - earliest_s;
}

}  // namespace

Recording recording_of(const StreamedAxis& axis, const std::vector<StreamSample>& samples) {
  const auto step = std::max<std::int64_t>(1, std::lround(1.0 / (axis.rate_Hz * axis.tick_s)));
  Recording recording;
  recording.samples = samples.size();
  bool irregular = false;
  recording.arrival_spread_s = arrival_spread_s(samples, axis.tick_s);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const std::int64_t gap = samples[i].tick - samples[i - 1].tick;
    irregular |= gap != step;
    recording.lost += gap > step + step / 2 ? static_cast<std::size_t>((gap + step / 2) / step - 1) : 0U;
  }
  recording.log =
      log_head(axis.resolution_m, axis.constant_N_per_A, axis.mass_kg, axis.hash, irregular, recording.lost);
  for (const StreamSample& sample : samples) {
    recording.log +=
        fmt::format("{:.6f},{},{:.6g}\n", static_cast<double>(sample.tick - samples[0].tick) * axis.tick_s,
                    sample.counts, sample.current_A);
  }
  return recording;
}

Recording record_stream(SdoClient& drive, double seconds, double rate_Hz, const Show& show) {
  show("ask the drive", -1.0);
  DriveStream stream(drive, rate_Hz, DriveStream::With::motion);
  const auto wanted = static_cast<std::size_t>(std::lround(seconds * rate_Hz));
  return recording_of(stream.axis(), take(drive, stream, wanted, show));
}

TraceData fetch_trace(SdoClient& drive, const Show& show) {
  const std::uint32_t capacity = drive.read(kTraceIndex, 9);
  std::uint32_t last = 0;
  for (int unchanged = 0; drive.read(kTraceIndex, 2) != 3;) {
    const std::uint32_t now = drive.read(kTraceIndex, 8);
    if (now > capacity) drive.fail("the trace has more samples than it can hold");
    unchanged = now == last ? unchanged + 1 : 0;
    last = now;
    if (unchanged > 10000) drive.fail("the trace does not fill; does the tick run?");
    if (capacity > 0) show("trace", static_cast<double>(now) / capacity);
  }
  const std::vector<std::uint8_t> data =
      drive.upload(kTraceDataIndex, 0, [&](double f) { show("read the trace", f); });
  TraceData trace;
  if (data.size() < sizeof trace.head) drive.fail("the trace is cut short");
  std::memcpy(&trace.head, data.data(), sizeof trace.head);
  if (trace.head.magic != TraceHead::kMagic || trace.head.head_bytes < sizeof trace.head ||
      data.size() != trace.head.head_bytes + sizeof(TraceSample) * trace.head.samples) {
    drive.fail("the trace is of another version");
  }
  trace.samples.resize(trace.head.samples);
  if (!trace.samples.empty()) {
    std::memcpy(trace.samples.data(), data.data() + trace.head.head_bytes,
                sizeof(TraceSample) * trace.samples.size());
  }
  check_axis(drive, static_cast<double>(trace.head.tick_s),
             static_cast<double>(trace.head.encoder_resolution_m),
             static_cast<double>(trace.head.motor_constant_N_per_A));
  return trace;
}

Recording record_trace(SdoClient& drive, std::uint32_t decimation, const Show& show) {
  drive.write(kTraceIndex, 1, 0, 1);
  drive.write(kTraceIndex, 3, decimation, 2);
  drive.write(kTraceIndex, 4, 0, 1);
  drive.write(kTraceIndex, 7, 0, 2);
  drive.write(kTraceIndex, 1, 1, 1);
  const auto [head, samples] = fetch_trace(drive, show);
  Recording recording;
  recording.samples = samples.size();
  recording.log = log_head(static_cast<double>(head.encoder_resolution_m),
                           static_cast<double>(head.motor_constant_N_per_A),
                           static_cast<double>(head.mass_kg), head.model_hash, false, 0);
  const double step_s = static_cast<double>(head.tick_s) * head.decimation;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    recording.log += fmt::format("{:.7f},{},{:.6g}\n", static_cast<double>(i) * step_s, samples[i].counts,
                                 samples[i].current_A);
  }
  return recording;
}

}  // namespace slipstack::workbench
