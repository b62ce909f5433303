// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/measure_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "firmware/canopen/profile/user_units.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/can/drive/drive_gains.h"
#include "workbench/can/drive/trace_data.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

constexpr std::size_t kPeriodSamples = 1024;
// What is below these lines of a band belongs to the next, ten times slower one.
constexpr std::size_t kFirstLine = 8;
constexpr std::size_t kFirstSlowLine = 4;
constexpr double kLowBandDeviation_m = 1e-4;
constexpr double kStart_s = 0.3;  // from the command of a move until its velocity is constant and settled

struct Band {
  std::size_t decimation = 1;
  std::size_t lowest = 0;
  std::size_t highest = 0;
  std::size_t settle = 1;  // periods, 0.2 s at 10 kHz and more
  double amplitude_A = 0.0;
};

struct DriveFacts {
  bool profile_velocity = false;
  DriveController controller;
  double resolution_m = 0.0;
  double constant_N_per_A = 0.0;
  double limit_A = 0.0;
  std::size_t capacity = 0;
};

DriveFacts ask(SdoClient& drive) {
  require_slipstack_drive(drive);
  const std::uint32_t mode = drive.read(0x6061, 0);
  if (!is_enabled(drive) || (mode != 1 && mode != 3)) {
    drive.fail(
        "must be enabled in profile position or profile velocity mode (6060h = 1 or 3), since the loop "
        "is measured closed");
  }
  DriveFacts facts;
  facts.profile_velocity = mode == 3;
  facts.controller = read_controller(drive);
  facts.resolution_m = drive.read_real(kAxisIndex, 1);
  facts.constant_N_per_A = drive.read_real(kAxisIndex, 3);
  facts.limit_A = drive.read_real(kAxisIndex, 9);
  facts.capacity = drive.read(kTraceIndex, 9);
  if (facts.capacity < 2 * kPeriodSamples)
    drive.fail(fmt::format("its trace of {} samples is less than two periods", facts.capacity));
  if (!(facts.controller.velocity_gain_N_s_per_m > 0.0))
    drive.fail("has no velocity gain (2000h:06); without feedback the axis would drift away");
  return facts;
}

// From the highest frequency downwards.
std::vector<Band> bands_of(const DriveFacts& facts, const LoopMeasurement& wanted) {
  const double rate_Hz = 1.0 / facts.controller.tick_s;
  const double highest_Hz = wanted.highest_Hz > 0.0 ? wanted.highest_Hz : 0.15 * rate_Hz;
  if (highest_Hz > 0.24 * rate_Hz)
    throw UsageError(fmt::format("--to: at most {:.0f} Hz with this tick", 0.24 * rate_Hz));
  if (!(wanted.lowest_Hz < 0.5 * highest_Hz))
    throw UsageError(
        fmt::format("--from: must be below half of {:.4g} Hz, the highest frequency", highest_Hz));
  const double most_A = wanted.amplitude_A > 0.0 ? wanted.amplitude_A : 0.1 * facts.limit_A;
  if (most_A > 0.5 * facts.limit_A)
    throw UsageError(
        fmt::format("--amplitude: at most half of the current limit, {:.4g} A", 0.5 * facts.limit_A));
  const double stiffness = facts.controller.position_gain_per_s * facts.controller.velocity_gain_N_s_per_m;
  const double gentle_A = kLowBandDeviation_m * stiffness / facts.constant_N_per_A;
  std::vector<Band> bands;
  double to_Hz = highest_Hz;
  for (std::size_t decimation = 1; decimation <= 100 && to_Hz > wanted.lowest_Hz; decimation *= 10) {
    const double line_Hz = rate_Hz / static_cast<double>(decimation * kPeriodSamples);
    const auto wanted_line = static_cast<std::size_t>(std::lround(wanted.lowest_Hz / line_Hz));
    Band band;
    band.decimation = decimation;
    band.settle = decimation == 1 ? 2 : 1;
    band.lowest = std::max(wanted_line, decimation == 1 ? kFirstLine : kFirstSlowLine);
    band.highest = static_cast<std::size_t>(std::ceil(to_Hz / line_Hz));
    to_Hz = static_cast<double>(band.lowest) * line_Hz;
    if (band.highest <= band.lowest + 2) continue;
    band.highest += (band.lowest + band.highest) % 2;
    band.amplitude_A = decimation == 1 ? most_A : std::min(most_A, gentle_A);
    bands.push_back(band);
  }
  return bands;
}

/// Stops what runs when the measurement ends, however it does.
class ExcitationGuard {
 public:
  explicit ExcitationGuard(SdoClient& drive) : drive_(drive) {}
  ExcitationGuard(const ExcitationGuard&) = delete;
  ExcitationGuard& operator=(const ExcitationGuard&) = delete;
  ~ExcitationGuard() {
    try {
      drive_.try_write(kExcitationIndex, 1, 0, 1);
      drive_.try_write(kTraceIndex, 1, 0, 1);
      drive_.try_write(kTraceIndex, 10, 0, 1);
    } catch (const std::exception&) {  // the bus is gone: the drive ends by itself
    }
  }

 private:
  SdoClient& drive_;
};

void wait_ticks(SdoClient& drive, std::uint32_t ticks) {
  const std::uint32_t begin = drive.read(kTimingIndex, 4);
  while (drive.read(kTimingIndex, 4) - begin < ticks) {
  }
}

/// Moves of one velocity to and fro, each long enough for a capture.
class Mover {
 public:
  Mover(SdoClient& drive, const DriveFacts& facts, double velocity_mps)
      : drive_(drive), facts_(facts), velocity_mps_(velocity_mps), forward_(velocity_mps > 0.0) {
    if (velocity_mps == 0.0) return;
    std::array<std::uint32_t, 6> factors{};
    std::size_t at = 0;
    for (const std::uint16_t index : std::array<std::uint16_t, 3>{0x608F, 0x6091, 0x6092}) {
      for (const std::uint8_t sub : std::array<std::uint8_t, 2>{1, 2}) factors[at++] = drive.read(index, sub);
    }
    const auto units = UserUnits::of(factors, 0);
    if (!units) drive.fail("its user units (608Fh, 6091h, 6092h) are none");
    users_per_m_ = 1.0 / (facts.resolution_m * static_cast<double>(units->counts_per_user()));
    if (facts.profile_velocity) return;
    velocity_.emplace(drive, std::uint16_t{0x6081}, std::uint8_t{0}, 4);
  }
  Mover(const Mover&) = delete;
  Mover& operator=(const Mover&) = delete;
  ~Mover() = default;

  /// Begins a move that lasts `seconds` at the velocity, and a while more for the bus; waits until it has it.
  void begin(double seconds) {
    if (velocity_mps_ == 0.0) return;
    if (facts_.profile_velocity) {
      note_begin();
      return run();
    }
    const double way_m = (1.1 * seconds + kStart_s + 0.2) * std::fabs(velocity_mps_);
    const std::int32_t from = note_begin();
    const double to = from + (forward_ ? 1.0 : -1.0) * way_m * users_per_m_;
    forward_ = !forward_;
    if (std::fabs(to) > 2.1e9) drive_.fail("--velocity: the move leaves the range of positions");
    go_to(static_cast<std::int32_t>(std::lround(to)));
    wait_ticks(drive_, static_cast<std::uint32_t>(kStart_s / facts_.controller.tick_s));
  }
  /// Waits for its end.
  void end() {
    if (velocity_mps_ == 0.0) return;
    if (facts_.profile_velocity) ask_for(0.0);
    for (int i = 0; (drive_.read(0x6041, 0) & 0x0400) == 0; ++i) {
      if (i > 100000) drive_.fail("the move does not end");
    }
  }

  /// Back to where the first move began: an odd number of moves has left the axis displaced, and the next
  /// measurement would begin there, and end at the limit of the travel one day.
  void back() {
    if (!begin_) return;
    if (!facts_.profile_velocity) {
      go_to(*begin_);
      return end();
    }
    const std::int32_t way = way_back();
    ask_for(way > 0 ? std::fabs(velocity_mps_) : -std::fabs(velocity_mps_));
    while (way > 0 ? way_back() > 0 : way_back() < 0) {
      if (!is_enabled(drive_)) drive_.fail("left operation enabled on the way back");
    }
    end();
  }

 private:
  // The position, users.
  std::int32_t note_begin() {
    const auto here = static_cast<std::int32_t>(drive_.read(0x6064, 0));
    if (!begin_) begin_ = here;
    return here;
  }
  std::int32_t way_back() {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(*begin_) - drive_.read(0x6064, 0));
  }
  void go_to(std::int32_t users) {
    velocity_->set(static_cast<std::uint32_t>(std::lround(std::fabs(velocity_mps_) * users_per_m_)));
    drive_.write(0x607A, 0, static_cast<std::uint32_t>(users), 4);
    drive_.write(0x6040, 0, 0x2F, 2);
    drive_.write(0x6040, 0, 0x3F, 2);
    drive_.write(0x6040, 0, 0x2F, 2);
  }
  // Profile velocity: until it is constant.
  void run() {
    ask_for(forward_ ? std::fabs(velocity_mps_) : -std::fabs(velocity_mps_));
    forward_ = !forward_;
    wait_ticks(drive_, static_cast<std::uint32_t>(kStart_s / facts_.controller.tick_s));
  }
  void ask_for(double velocity_mps) {
    const auto users = static_cast<std::int32_t>(std::lround(velocity_mps * users_per_m_));
    drive_.write(0x60FF, 0, static_cast<std::uint32_t>(users), 4);
  }

  SdoClient& drive_;
  const DriveFacts& facts_;
  double velocity_mps_;
  double users_per_m_ = 1.0;
  std::optional<RestoredObject> velocity_;  // 6081h
  std::optional<std::int32_t> begin_;       // of the first move, users
  bool forward_;
};

[[noreturn]] void ended(SdoClient& drive, std::uint32_t state, const LoopMeasurement& wanted) {
  if (!is_enabled(drive)) {
    drive.fail(
        fmt::format("left operation enabled while it was excited, error {:04x}h; with less "
                    "--amplitude it may stay",
                    drive.read(0x603F, 0)));
  }
  if (state == 5) {
    drive.fail(fmt::format("the position left the bound of {:.3g} mm; less --amplitude or more --deviation",
                           1e3 * wanted.deviation_m));
  }
  drive.fail("the excitation was ended: the reference accelerated, or another master stopped the axis");
}

void set_excitation(SdoClient& drive, const DriveFacts& facts, const Band& band, std::size_t periods,
                    const LoopMeasurement& wanted) {
  const double period_ticks = static_cast<double>(kPeriodSamples * band.decimation);
  const double line_Hz = 1.0 / (period_ticks * facts.controller.tick_s);
  drive.write(kExcitationIndex, 3, wanted.at_force ? 0 : 1, 1);
  if (wanted.at_force) {
    drive.write_real(kExcitationIndex, 4, band.amplitude_A);
  } else {
    const double stiffness = facts.controller.position_gain_per_s * facts.controller.velocity_gain_N_s_per_m;
    drive.write_real(kExcitationIndex, 5, band.amplitude_A * facts.constant_N_per_A / stiffness);
  }
  drive.write_real(kExcitationIndex, 6, static_cast<double>(band.lowest) * line_Hz);
  drive.write_real(kExcitationIndex, 7, static_cast<double>(band.highest) * line_Hz);
  drive.write(kExcitationIndex, 8, static_cast<std::uint32_t>(period_ticks), 4);
  drive.write(kExcitationIndex, 9, static_cast<std::uint32_t>(periods), 2);
  drive.write_real(kExcitationIndex, 10, wanted.deviation_m);
  drive.write(kTraceIndex, 3, static_cast<std::uint32_t>(band.decimation), 2);
  drive.write(kTraceIndex, 4, 0, 1);
  drive.write(kTraceIndex, 7, 0, 2);
  drive.write(kTraceIndex, 10, 1, 1);
}

ExcitedRecord record_of(const TraceData& trace, const DriveFacts& facts, const Band& band, bool at_force) {
  ExcitedRecord record;
  record.at_force = at_force;
  record.tick_s = facts.controller.tick_s;
  record.decimation = band.decimation;
  record.period_samples = kPeriodSamples;
  record.lowest = band.lowest;
  record.highest = band.highest;
  const std::int32_t first = trace.samples.front().counts;
  for (const TraceSample& sample : trace.samples) {
    // Counts may go round.
    const auto counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(sample.counts) -
                                                  static_cast<std::uint32_t>(first));
    record.position_m.push_back(static_cast<double>(counts) * facts.resolution_m);
    record.force_N.push_back(static_cast<double>(sample.current_A) * facts.constant_N_per_A);
    record.excitation.push_back(static_cast<double>(std::bit_cast<float>(sample.reference)));
  }
  return record;
}

/// One capture: excite, wait for the steady state, trace, stop. `limits`: those that were met.
ExcitedRecord capture(SdoClient& drive, const DriveFacts& facts, const Band& band, Mover& mover,
                      const LoopMeasurement& wanted, std::uint32_t& limits, const Show& show) {
  const std::size_t periods = facts.capacity / kPeriodSamples;
  const double period_s = static_cast<double>(kPeriodSamples * band.decimation) * facts.controller.tick_s;
  // It is stopped when the trace is full; if the master is gone, it ends by itself.
  set_excitation(drive, facts, band, band.settle + periods + 2, wanted);
  mover.begin(static_cast<double>(band.settle + periods) * period_s);
  if (const std::uint32_t code = drive.try_write(kExcitationIndex, 1, 1, 1); code != 0)
    drive.fail(fmt::format("the excitation is refused (2320h:01): {}", abort_text(code)));
  while (drive.read(kExcitationIndex, 11) < band.settle) {
    const std::uint32_t state = drive.read(kExcitationIndex, 2);
    if (state != 1) ended(drive, state, wanted);
  }
  drive.write(kTraceIndex, 1, 1, 1);
  while (drive.read(kTraceIndex, 2) != 3) {
    const std::uint32_t state = drive.read(kExcitationIndex, 2);
    if (state != 1 && drive.read(kTraceIndex, 2) != 3) ended(drive, state, wanted);
    show("excite", static_cast<double>(drive.read(kTraceIndex, 8)) / static_cast<double>(facts.capacity));
  }
  limits |= drive.read(kExcitationIndex, 12);
  drive.write(kExcitationIndex, 1, 0, 1);
  mover.end();
  while (drive.read(kExcitationIndex, 2) == 1) {
  }
  const TraceData trace = fetch_trace(drive, show);
  if (trace.head.second_channel != 1 || trace.samples.size() < 2 * kPeriodSamples)
    drive.fail("the trace is not of the excitation; did another master arm it?");
  return record_of(trace, facts, band, wanted.at_force);
}

}  // namespace

LoopRecording measure_loop(SdoClient& drive, const LoopMeasurement& wanted, const Show& show) {
  show("ask the drive", -1.0);
  const DriveFacts facts = ask(drive);
  if (!wanted.at_force && !(facts.controller.position_gain_per_s > 0.0))
    drive.fail(
        "has no position gain (2000h:05): a change of the position reference does nothing; use --at force");
  LoopRecording recording;
  recording.drive = facts.controller;
  recording.velocity_mps = wanted.velocity_mps;
  recording.force_limit_N = facts.limit_A * facts.constant_N_per_A;
  recording.motor_constant_N_per_A = facts.constant_N_per_A;
  const ExcitationGuard guard(drive);
  Mover mover(drive, facts, wanted.velocity_mps);
  drive.write(kExcitationIndex, 1, 0, 1);
  drive.write(kTraceIndex, 1, 0, 1);
  std::uint32_t limits = 0;
  for (const Band& band : bands_of(facts, wanted)) {
    std::vector<ExcitedRecord> captures;
    captures.reserve(static_cast<std::size_t>(wanted.captures));
    for (int i = 0; i < wanted.captures; ++i)
      captures.push_back(capture(drive, facts, band, mover, wanted, limits, show));
    recording.bands.push_back(std::move(captures));
  }
  mover.back();
  if (limits != 0) {
    recording.notes.push_back(fmt::format(
        "Limits were met (2200h:0A, bits {:04X}h): the response is that of a limited loop; measure "
        "with less --amplitude.",
        limits));
  }
  return recording;
}

}  // namespace slipstack::workbench
