// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/plan_on_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <exception>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/base/cancel.h"
#include "workbench/can/drive/cyclic_stream.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/can/drive/drive_stream.h"
#include "workbench/can/drive/drive_words.h"
#include "workbench/serve/live/driven_axis.h"

namespace slipstack::workbench {

using namespace slipstack::canopen;

namespace {

constexpr double kRounding = 1.0 + 1e-6;  // of values in float
constexpr double kPlaceRounding_m = 1e-9;
constexpr std::uint32_t kFaultBit = 1U << 3U;  // 6041h

double counts_m(SdoClient& drive, std::uint16_t index, std::uint8_t sub, double resolution_m) {
  return static_cast<double>(static_cast<std::int32_t>(drive.read(index, sub))) * resolution_m;
}

/// SYNC and PDOs as they are stored, at the end of this.
class ReleasedBus {
 public:
  explicit ReleasedBus(SdoClient& drive) : drive_(drive) {}
  ReleasedBus(const ReleasedBus&) = delete;
  ReleasedBus& operator=(const ReleasedBus&) = delete;
  ~ReleasedBus() {
    try {
      drive_.listen_also_to({});
      restart_communication(drive_);
    } catch (const std::exception&) {  // the bus is gone; what the drive does then is its own supervision's
    }
  }

 private:
  SdoClient& drive_;
};

PlanLimit limit(const char* quantity, const char* unit, double planned, double allowed, const char* source) {
  const bool known = std::isfinite(allowed) && allowed > 0.0;
  return {quantity, unit, planned, known ? allowed : std::nan(""), !known || planned <= allowed * kRounding,
          source};
}

std::string why_not(SdoClient& drive, const DriveMotion& plan, const PlanOnAxis& found) {
  const std::uint32_t word = drive.read(0x6041, 0);
  if ((word & kFaultBit) != 0) {
    const std::uint32_t error = drive.read(0x603F, 0);
    return fmt::format("the drive has a fault ({:04X}h, {}); reset it first", error,
                       error_words(static_cast<std::uint16_t>(error)));
  }
  if (is_enabled(drive)) return "the drive is enabled by another master; disable it first";
  if (!plan.places_known && drive.read(kReferenceIndex, 5) == 0)
    return "the drive does not know its positions (2012h:05), so that nobody knows where the plan would go; "
           "home it first";
  for (const PlanLimit& one : found.limits) {
    if (!one.fits) {
      return fmt::format("{} leaves what the axis may do ({}); plan within its limits", one.quantity,
                         one.source);
    }
  }
  return "";
}

std::vector<std::int32_t> set_points_of(const DriveMotion& plan, int period_ms, double resolution_m) {
  std::vector<std::int32_t> counts;
  const double step = plan.rate_Hz * 1e-3 * period_ms;
  const auto last = static_cast<double>(plan.position_m.size() - 1);
  // Between the plan's samples on a straight line: they are closer than the drive's set-points, or as close.
  for (double at = 0.0; at < last + 0.5 * step; at += step) {
    const double place = std::min(at, last);
    const auto before = static_cast<std::size_t>(place);
    const std::size_t after = std::min(before + 1, plan.position_m.size() - 1);
    const double share = place - static_cast<double>(before);
    const double position_m =
        plan.position_m[before] + share * (plan.position_m[after] - plan.position_m[before]);
    counts.push_back(static_cast<std::int32_t>(std::lround(position_m / resolution_m)));
  }
  return counts;
}

}  // namespace

double DriveMotion::low_m() const {
  return *std::min_element(position_m.begin(), position_m.end());
}

double DriveMotion::high_m() const {
  return *std::max_element(position_m.begin(), position_m.end());
}

PlanOnAxis check_plan_on(SdoClient& drive, const DriveMotion& plan) {
  require_slipstack_drive(drive);
  const double resolution_m = drive.read_real(kAxisIndex, 1);
  if (!(resolution_m > 0.0)) drive.fail("2000h:01 is no resolution; is it commissioned?");
  PlanOnAxis found;
  found.begin_m = plan.position_m.front();
  found.now_m = counts_m(drive, 0x6063, 0, resolution_m);
  const auto low = static_cast<std::int32_t>(drive.read(0x607D, 1));
  const auto high = static_cast<std::int32_t>(drive.read(0x607D, 2));
  const bool limited = low != INT32_MIN && high != INT32_MAX && low < high;
  const double low_m = limited ? low * resolution_m : plan.log_low_m;
  const double high_m = limited ? high * resolution_m : plan.log_high_m;
  const char* const of_place = limited ? "software limits, 607Dh" : "where the logs were; 607Dh is not set";
  found.limits.push_back(
      {"lowest position", "m", plan.low_m(), low_m, plan.low_m() >= low_m - kPlaceRounding_m, of_place});
  found.limits.push_back(
      {"highest position", "m", plan.high_m(), high_m, plan.high_m() <= high_m + kPlaceRounding_m, of_place});
  found.limits.push_back(
      limit("velocity", "m/s", plan.velocity_mps, drive.read_real(kAxisIndex, 0x0B), "2000h:0B"));
  found.limits.push_back(
      limit("acceleration", "m/s2", plan.acceleration_mps2, drive.read_real(kAxisIndex, 0x0C), "2000h:0C"));
  found.limits.push_back(limit("force", "N", plan.force_N,
                               drive.read_real(kAxisIndex, 9) * drive.read_real(kAxisIndex, 3),
                               "largest current, 2000h:09, times 2000h:03"));
  found.refused = why_not(drive, plan, found);
  return found;
}

PlanSampling sampling_for(double rate_Hz) {
  constexpr double kWhole = 1e-6;
  constexpr int kMost_ms = 100;
  const double period_ms = 1e3 / rate_Hz;
  const int whole = static_cast<int>(std::lround(std::min(period_ms, 1e6)));
  if (whole < 1 || whole > kMost_ms || std::fabs(period_ms - whole) > kWhole * period_ms) return {};
  const int period = whole % 2 == 0 ? 2 : 1;
  return {period, whole / period};
}

Recording run_plan_on(SdoClient& drive, const DriveMotion& plan, const PlanSampling& sampling,
                      const Show& show) {
  show("ask the drive", -1.0);
  const PlanOnAxis check = check_plan_on(drive, plan);
  if (!check.refused.empty()) drive.fail(check.refused);
  StreamedAxis streamed;
  streamed.rate_Hz = sampling.rate_Hz();
  streamed.tick_s = drive.read_real(kAxisIndex, 2);
  streamed.resolution_m = drive.read_real(kAxisIndex, 1);
  streamed.constant_N_per_A = drive.read_real(kAxisIndex, 3);
  streamed.mass_kg = model_mass_kg(drive);
  streamed.hash = drive.read(kModelIndex, 2);
  check_axis(drive, streamed.tick_s, streamed.resolution_m, streamed.constant_N_per_A);
  const double limit_A = drive.read_real(kAxisIndex, 9);

  CyclicStream stream(drive, sampling.period_ms);
  StreamedMotion done;
  const std::vector<std::int32_t> set_points = set_points_of(plan, sampling.period_ms, streamed.resolution_m);
  {
    RestoredObjects changed(drive);
    changed.set(0x60C2, 1, drive.read(0x60C2, 1), 1);  // which the stream sets
    changed.set(0x60C2, 2, drive.read(0x60C2, 2), 1);
    changed.set(0x2403, 0, kStreamTimeOut_ms, 2);
    const ReleasedBus released(drive);
    stream.configure();
    DrivenAxis axis(drive);
    show("move to where the plan begins", -1.0);
    axis.move_to_place(set_points.front());
    if (!axis.arrives()) drive.fail("does not arrive where the plan begins; see its status");
    axis.follow_set_points();
    done = stream.follow(set_points, limit_A, streamed.tick_s,
                         [&](double fraction) { show("the axis follows the plan", fraction); });
    if (done.disabled) {
      const std::uint32_t error = drive.read(0x603F, 0);
      drive.fail(error == 0 ? std::string("was disabled on the way by somebody else")
                            : fmt::format("stopped on the way: {:04X}h, {}", error,
                                          error_words(static_cast<std::uint16_t>(error))));
    }
    const double off_m =
        done.samples.empty()
            ? 1.0
            : std::fabs(done.samples.back().reference_counts - set_points.back()) * streamed.resolution_m;
    if (off_m > std::max(kArrived_m, 2.0 * streamed.resolution_m))
      drive.fail("was stopped on the way, by a limit switch or a limit of the drive (607Dh, 607Fh, 60C5h)");
  }
  const auto wanted = static_cast<double>(set_points.size());
  if (static_cast<double>(done.samples.size()) < (1.0 - kMostLost) * wanted) {
    drive.fail(fmt::format("{:.1f} % of the samples were lost on the bus; find out what delays it",
                           100.0 - 100.0 * static_cast<double>(done.samples.size()) / wanted));
  }
  // By the drive's ticks: samples that were lost leave the others in their place.
  const double ticks = 1e-3 * sampling.period_ms * sampling.every / streamed.tick_s;
  std::vector<StreamSample> samples;
  for (const SyncSample& one : done.samples) {
    const double place = static_cast<double>(one.tick - done.samples.front().tick) / ticks;
    if (std::fabs(place - std::round(place)) * ticks > 0.5) continue;
    StreamSample sample;
    sample.tick = one.tick;
    sample.counts = one.counts;
    sample.current_A = one.current_A;
    samples.push_back(sample);
  }
  return recording_of(streamed, samples);
}

}  // namespace slipstack::workbench
