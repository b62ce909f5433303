// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/can_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/canopen/model/staged_model.h"
#include "firmware/canopen/telemetry/trace.h"
#include "firmware/control/supervision/faults.h"
#include "firmware/effects/model_hash.h"
#include "workbench/base/text.h"
#include "workbench/can/drive/cyclic_stream.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/can/drive/drive_before.h"
#include "workbench/can/drive/trace_data.h"
#include "workbench/loop/loop_parameters.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;
using nlohmann::json;

constexpr std::uint8_t kHold = 1;  // profile position: no set-point is due
constexpr std::uint8_t kHoming = 6;
constexpr std::uint8_t kCyclicPosition = 8;
constexpr std::uint8_t kCyclicTorque = 10;
constexpr std::uint32_t kHere = 37;  // homing method: where the axis is
constexpr int kLongestWait_ms = 10'000;
constexpr int kRest_ms = 100;
constexpr double kFarthestShift_m = 0.2e-3;  // of a motion, to begin where the axis is held
constexpr double kAssumed_mps2 = 20.0;       // of the largest force, before the mass is known
constexpr double kOtherConstant = 1.00001;   // of the motor: another machine for the check of the direction
constexpr std::uint32_t kPulseTimeOut_ms = 50;  // without a master the force ends after it (2403h)
constexpr int kMorePulses = 3;
constexpr std::uint16_t kBeforePulse = 100;  // samples of the trace

// 2000h by sub-index, as docs/object-dictionary.md has it.
enum AxisSub : std::uint8_t {
  kObserverSubIndex = 0x04,
  kPositionGain = 0x05,
  kVelocityGain = 0x06,
  kIntegral = 0x07,
  kDisturbanceShare = 0x08,
  kCurrentLimit = 0x09,
  kVelocityLimit = 0x0B,
  kAccelerationLimit = 0x0C,
  kJerkLimit = 0x0D,
  kQuickStop = 0x0E,
  kFollowingErrorLimit = 0x0F,
  kStallCurrent = 0x13,
  kNotch1 = 0x1B,
  kNotch2 = 0x1E,
};

/// What stays as it was deployed: the gains, and that friction is compensated.
bool is_kept(std::uint16_t index, std::uint8_t sub) {
  if (index != kAxisIndex) return false;
  return (sub >= kObserverSubIndex && sub <= kDisturbanceShare) || sub == kNotch1 || sub == kNotch2 ||
         sub == kCompensateSub;
}

std::vector<std::uint8_t> image_of(const ModelParameters& model) {
  std::vector<std::uint8_t> image;
  model_words(model, [&image](std::size_t, std::uint32_t word) {
    for (int i = 0; i < 4; ++i) image.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  });
  return image;
}

class CanAxis final : public LiveAxis {
 public:
  CanAxis(SdoClient& drive, const BusAxis& told, DriveMemory memory)
      : drive_(drive),
        memory_(std::move(memory)),
        stream_(drive, told.period_ms),
        kept_(kept_in(drive, memory_)),
        before_(kept_.at("before")) {
    off();
    describe(told);
    reference();
    stream_.configure();
  }

  const Nameplate& nameplate() const override { return plate_; }
  double used_s() const override { return used_s_; }
  double position_m() const override {
    return answered([&] { return is_enabled(drive_) ? counts_m(0x2200, 9) : counts_m(0x6063, 0); });
  }

  Direction check_direction() override {
    return answered([&] {
      // The drive checks what has not passed (2501h:05): a machine that has is taken for another one first.
      // Its second check, with the constant that counts, comes when it is enabled the next time.
      const Used used(*this);
      Direction found = pushed(1.0);
      if (found == Direction::kRight && !pushed_) found = pushed(kOtherConstant);
      drive_.write_real(kAxisIndex, 3, plate_.motor_constant_N_per_A);
      return found;
    });
  }

  void reverse_motor() override {
    answered([&] {
      if (kept_.at("reversed").get<bool>()) return;  // in an earlier run
      before_.set_motor_reversed(before_.value(kScalesIndex, 2) == 0);
      kept_["before"] = before_.json();
      kept_["reversed"] = true;
      // In force from a start on: what is stored has to be what there was, but for this.
      before_.restore(drive_);
      restart_communication(drive_);
      store_parameters(drive_);
      drive_.nmt(0x81);
      wait_for_start(drive_);
      reference_here();
      stream_.configure();
      // Not before it is done: a run that was cut in between does it again.
      memory_.keep(kept_.dump() + "\n");
    });
  }

  AxisRecord pulse(double force_N, double seconds) override {
    return answered([&] {
      AxisRecord record = pulsed(force_N, seconds);
      // A master that was held up for longer than the drive waits for it.
      for (int i = 0; i < kMorePulses && late_; ++i) record = pulsed(force_N, seconds);
      return record;
    });
  }

  std::string deploy(const DriveSettings& settings, const Terms& target_terms) override {
    return answered([&] {
      const Used used(*this);
      const ModelParameters model =
          target_terms.empty() ? mass_only_model(settings.mass_kg) : target_parameters(target_terms);
      return configured(settings, model);
    });
  }

  AxisRecord run(const SetPoints& motion) override {
    return answered([&] { return streamed(motion); });
  }

  void switch_off() override {
    answered([&] { off(); });
  }

  std::string keep() override {
    return answered([&] {
      off();
      before_.restore_objects(drive_, is_kept);
      const std::uint32_t hash = drive_.read(kModelIndex, 1);
      if (const auto refused = apply_staged(drive_, hash))
        drive_.fail(fmt::format("does not take its own limits back (result {}, 2140h:04)", *refused));
      restart_communication(drive_);
      store_parameters(drive_);
      return fmt::format("model {:08x} and its gains are in the drive's flash, stored {} times so far", hash,
                         drive_.read(kCountersIndex, 9));
    });
  }

  void give_back() override {
    answered([&] {
      off();
      before_.restore(drive_);
      restart_communication(drive_);
    });
  }

 private:
  /// Counts what passes of the axis's time, by the drive's ticks.
  class Used {
   public:
    explicit Used(CanAxis& axis) : axis_(axis), from_(axis.drive_.read(kTimingIndex, 4)) {}
    Used(const Used&) = delete;
    Used& operator=(const Used&) = delete;
    ~Used() {
      try {
        axis_.used_s_ +=
            axis_.plate_.tick_s * static_cast<double>(axis_.drive_.read(kTimingIndex, 4) - from_);
      } catch (const std::exception&) {  // the drive is gone, which the work itself says
      }
    }

   private:
    CanAxis& axis_;
    std::uint32_t from_;
  };

  /// What the bus does not answer is a lost drive.
  template <class Work>
  static auto answered(Work&& work) -> decltype(work()) {
    try {
      return work();
    } catch (const UsageError& error) {
      throw DriveLost(error.what());
    }
  }

  /// What was kept by an earlier run; else what the drive holds now, which is then kept.
  static json kept_in(SdoClient& drive, const DriveMemory& memory) {
    require_slipstack_drive(drive);
    if (!memory.kept.empty()) {
      // A run that was killed between two motions has left the axis held.
      if (is_enabled(drive)) drive.write(0x6040, 0, 0, 2);
      return json::parse(memory.kept);
    }
    if (is_enabled(drive)) drive.fail("is enabled; disable the drive before its axis is commissioned");
    json kept = {{"before", DriveBefore(drive).json()},
                 {"referenced", drive.read(kReferenceIndex, 5) != 0},
                 {"reversed", false}};
    memory.keep(kept.dump() + "\n");
    return kept;
  }

  void describe(const BusAxis& told) {
    plate_.encoder_resolution_m = drive_.read_real(kAxisIndex, 1);
    plate_.tick_s = drive_.read_real(kAxisIndex, 2);
    plate_.motor_constant_N_per_A = before_.real(kAxisIndex, 3);
    plate_.current_limit_A = before_.real(kAxisIndex, kCurrentLimit);
    plate_.magnet_pitch_m = told.magnet_pitch_m;
    const double velocity_mps = before_.real(kAxisIndex, kVelocityLimit);
    plate_.largest_velocity_mps = std::min(velocity_mps, told.largest_velocity_mps.value_or(velocity_mps));
    plate_.largest_acceleration_mps2 =
        std::min(plate_.largest_acceleration_mps2, before_.real(kAxisIndex, kAccelerationLimit));
    if (!(plate_.current_limit_A > 0.0) || !(plate_.motor_constant_N_per_A > 0.0))
      drive_.fail(
          "has no current limit or no motor constant (2000h:09, :03); write those of the motor first");
    const bool counts = drive_.read(0x608F, 1) == drive_.read(0x608F, 2) &&
                        drive_.read(0x6091, 1) == drive_.read(0x6091, 2) &&
                        drive_.read(0x6092, 1) == drive_.read(0x6092, 2) && drive_.read(0x607E, 0) == 0;
    if (!counts) {
      drive_.fail(
          "has a user's unit or a polarity (608Fh, 6091h, 6092h, 607Eh); commission it in counts, and set "
          "them afterwards");
    }
    rated_N_ = 1e-3 * drive_.read(0x6075, 0) * plate_.motor_constant_N_per_A;
    if (told.low_m && told.high_m) {
      set_travel(*told.low_m, *told.high_m);
      return;
    }
    const auto low = static_cast<std::int32_t>(drive_.read(0x607D, 1));
    const auto high = static_cast<std::int32_t>(drive_.read(0x607D, 2));
    if (low != INT32_MIN && high != INT32_MAX && low < high)
      set_travel(low * plate_.encoder_resolution_m, high * plate_.encoder_resolution_m);
  }

  void set_travel(double low_m, double high_m) {
    plate_.low_m = low_m;
    plate_.travel_m = high_m - low_m;
  }

  /// Positions count from somewhere: from where the drive says, else from here.
  void reference() {
    if (drive_.read(kReferenceIndex, 5) != 0) return;
    if (kept_.at("referenced").get<bool>() || memory_.positions_matter) {
      drive_.fail(
          "no longer knows its positions (2012h:05): it was started anew since; home it as before, or begin "
          "anew in another folder");
    }
    if (plate_.travel_m > 0.0) {
      drive_.fail(
          "does not know its positions (2012h:05), so that nobody knows where its travel ends; home it "
          "first, "
          "or leave out --from and --to");
    }
    reference_here();
  }

  void reference_here() {
    if (drive_.read(kReferenceIndex, 5) != 0) return;
    drive_.write(0x6098, 0, kHere, 1);
    drive_.write(0x6060, 0, kHoming, 1);
    wait_ms(5);
    drive_.write(0x6040, 0, 0x10, 2);
    wait_ms(20);
    drive_.write(0x6040, 0, 0, 2);
    if (drive_.read(kReferenceIndex, 5) == 0) drive_.fail("takes no position zero (method 37 of 6098h)");
  }

  double counts_m(std::uint16_t index, std::uint8_t sub) const {
    return static_cast<double>(static_cast<std::int32_t>(drive_.read(index, sub))) *
           plate_.encoder_resolution_m;
  }

  /// Of the drive's time, whatever the master's clock is worth.
  void wait_ms(int milliseconds) const {
    const std::uint32_t from = drive_.read(kTimingIndex, 4);
    while (since_ms(from) < milliseconds) {
      CanFrame frame;
      static_cast<void>(drive_.link().receive(frame, 1));
    }
  }
  double since_ms(std::uint32_t tick) const {
    return 1e3 * plate_.tick_s * static_cast<double>(drive_.read(kTimingIndex, 4) - tick);
  }

  std::uint32_t state() const { return drive_.read(0x6041, 0) & 0x6FU; }
  bool faulted() const { return (state() & 0x4FU) == 0x0F || (state() & 0x4FU) == 0x08; }

  bool enable(std::uint8_t mode) {
    drive_.write(0x6060, 0, mode, 1);
    if (!is_enabled(drive_)) {
      for (const std::uint32_t word : {0x00U, 0x06U, 0x07U, 0x0FU}) {
        drive_.write(0x6040, 0, word, 2);
        wait_ms(3);
      }
    }
    for (int i = 0; i < kLongestWait_ms; ++i) {
      if (faulted()) return false;
      if (is_enabled(drive_) && drive_.read(0x6061, 0) == mode) return true;
      wait_ms(1);
    }
    return false;
  }

  void off() {
    if (is_enabled(drive_)) drive_.write(0x6040, 0, 0x07, 2);
    for (int i = 0; i < kLongestWait_ms && is_enabled(drive_); ++i) wait_ms(1);
    drive_.write(0x6040, 0, 0x00, 2);
    for (int i = 0; i < kLongestWait_ms && (drive_.read(0x6041, 0) & 0x4FU) == 0x0F; ++i) wait_ms(1);
    // The reset of a fault is an edge; then the axis comes to rest.
    drive_.write(0x6040, 0, 0x80, 2);
    wait_ms(3);
    drive_.write(0x6040, 0, 0x00, 2);
    wait_ms(kRest_ms);
  }

  std::string configured(const DriveSettings& settings, const ModelParameters& model) {
    if (is_enabled(drive_)) off();
    const double limit_A = settings.force_limit_N / plate_.motor_constant_N_per_A;
    // Set-points are whole counts, which makes a second difference of two counts of nothing.
    const double period_s = 1e-3 * stream_.period_ms();
    const double acceleration_mps2 =
        settings.acceleration_limit_mps2 + 2.0 * plate_.encoder_resolution_m / (period_s * period_s);
    const std::pair<std::uint8_t, double> values[] = {
        {kObserverSubIndex, settings.observer_rad_per_s},
        {kPositionGain, settings.position_gain_per_s},
        {kVelocityGain, settings.velocity_gain_N_s_per_m},
        {kIntegral, settings.integral_per_s},
        {kDisturbanceShare, 0.0},
        {kCurrentLimit, limit_A},
        {kVelocityLimit, settings.velocity_limit_mps},
        {kAccelerationLimit, acceleration_mps2},
        {kJerkLimit, settings.jerk_limit_mps3},
        {kQuickStop, acceleration_mps2},
        {kFollowingErrorLimit, settings.following_error_m},
        {kStallCurrent, 0.8 * limit_A},
        {kNotch1, 0.0},
        {kNotch2, 0.0},
    };
    for (const auto& [sub, value] : values) drive_.write_real(kAxisIndex, sub, value);
    limit_A_ = limit_A;
    for (const auto& [sub, on] :
         {std::pair{kCompensateSub, 1U}, std::pair{kAdaptLevelSub, 0U}, std::pair{kLastAxisSub, 0U}})
      drive_.write(kAxisIndex, sub, on, 1);
    const std::uint32_t hash = model_hash(model);
    try {
      drive_.download(kModelImageIndex, 0, image_of(model));
    } catch (const SdoAbort& refused) {
      if (refused.of_transport()) throw;
      return fmt::format("the drive does not take the model: {}", refused.what());
    }
    if (const auto refused = apply_staged(drive_, hash))
      return fmt::format("the controller refuses its parameters (status {})", *refused);
    if (drive_.read(kModelIndex, 2) == hash) return "";
    return "the controller does not report the hash of the model that it was given";
  }

  /// By the drive's own check; `constant`: of the motor's. Sets pushed_ to whether it was due.
  Direction pushed(double constant) {
    DriveSettings unknown;
    unknown.force_limit_N = plate_.force_limit_N();
    unknown.mass_kg = unknown.force_limit_N / kAssumed_mps2;
    unknown.acceleration_limit_mps2 = kAssumed_mps2;
    unknown.jerk_limit_mps3 = kAssumed_mps2 / 0.01;
    off();
    drive_.write_real(kAxisIndex, 3, constant * plate_.motor_constant_N_per_A);
    drive_.write(kDirectionIndex, 1, 1, 1);
    drive_.write_real(kDirectionIndex, 3, 0.5 * plate_.current_limit_A);
    drive_.write_real(kDirectionIndex, 4, std::max(0.1, 0.5 * plate_.current_limit_A));
    const std::uint32_t passed = drive_.read(kDirectionIndex, 5);
    const std::string refused = configured(unknown, mass_only_model(unknown.mass_kg));
    if (!refused.empty()) throw DriveLost(refused);
    const bool enabled = enable(kHold);
    const std::uint32_t error = drive_.read(0x603F, 0);
    off();
    pushed_ = !enabled || drive_.read(kDirectionIndex, 5) != passed;
    if (enabled) return Direction::kRight;
    if (error == error_code(Fault::kDirection)) return Direction::kReversed;
    if (error == error_code(Fault::kStall)) return Direction::kBlocked;
    throw DriveLost(error == 0 ? std::string("the drive cannot be enabled; is its amplifier ready?")
                               : fmt::format("the drive is at fault {:04X}h when it is enabled", error));
  }

  AxisRecord pulsed(double force_N, double seconds) {
    const Used used(*this);
    late_ = false;
    AxisRecord record;
    record.rate_Hz = 1.0 / plate_.tick_s;
    off();
    drive_.write(0x2403, 0, kPulseTimeOut_ms, 2);
    if (const std::string refused = applied(); !refused.empty()) throw DriveLost(refused);
    drive_.write(0x6071, 0, 0, 2);
    if (!enable(kCyclicTorque)) return stopped(std::move(record));
    const std::int32_t thousandths = force_thousandths(force_N);
    const double pushed_N = 1e-3 * thousandths * rated_N_;
    const double pushed_A = pushed_N / plate_.motor_constant_N_per_A;
    drive_.write(kTraceIndex, 1, 0, 1);
    drive_.write(kTraceIndex, 3, 1, 2);
    drive_.write(kTraceIndex, 4, pushed_A > 0.0 ? 1 : 2, 1);
    drive_.write(kTraceIndex, 5, 2, 1);
    drive_.write_real(kTraceIndex, 6, 0.25 * pushed_A);
    drive_.write(kTraceIndex, 7, kBeforePulse, 2);
    drive_.write(kTraceIndex, 0x0A, 0, 1);
    drive_.write(kTraceIndex, 1, 1, 1);
    push(thousandths, seconds);
    late_ = !is_enabled(drive_) && !faulted();
    if (!is_enabled(drive_)) return stopped(std::move(record));
    off();
    cut_pulse(record, pushed_N);
    return record;
  }

  /// 6071h; the rest of the pulse is the trace's.
  std::int32_t force_thousandths(double force_N) const {
    const double most = std::min(32767.0, 1e3 * plate_.force_limit_N() / rated_N_);
    return static_cast<std::int32_t>(std::lround(std::clamp(1e3 * force_N / rated_N_, -most, most)));
  }

  void push(std::int32_t thousandths, double seconds) {
    const auto target = [&](std::int32_t value) {
      drive_.write(0x6071, 0, static_cast<std::uint32_t>(value) & 0xFFFFU, 2);
    };
    const auto counts = [&] { return static_cast<std::int32_t>(drive_.read(0x6063, 0)); };
    // Written again and again, or the drive would take the master for dead (2403h).
    const std::uint32_t begin = drive_.read(kTimingIndex, 4);
    do target(thousandths);
    while (since_ms(begin) < 1e3 * seconds);
    // As long again, or until the axis comes back.
    const std::uint32_t turned = drive_.read(kTimingIndex, 4);
    std::int32_t farthest = counts();
    do {
      target(-thousandths);
      const std::int32_t now = counts();
      const std::int32_t back = thousandths > 0 ? farthest - now : now - farthest;
      if (back > kTurnedCounts) break;
      if (back < 0) farthest = now;
    } while (since_ms(turned) < 1e3 * seconds);
    target(0);
  }

  /// Of the trace, what the two forces did; the force is turned round where the current's sign changes.
  void cut_pulse(AxisRecord& record, double pushed_N) {
    const TraceData trace = fetch_trace(drive_, [](const std::string&, double) {});
    const double constant = plate_.motor_constant_N_per_A;
    const double sign = pushed_N < 0.0 ? -1.0 : 1.0;
    std::size_t turned = 0;
    for (std::size_t i = trace.head.trigger_place; i < trace.samples.size(); ++i) {
      const TraceSample& sample = trace.samples[i];
      const double force_N = static_cast<double>(sample.current_A) * constant;
      if (turned == 0 && sign * force_N < 0.0) turned = record.position_m.size();
      if (turned != 0 && sign * force_N > -0.25 * std::fabs(pushed_N) &&
          record.position_m.size() > turned + 5)
        break;  // the end of it
      record.position_m.push_back(static_cast<double>(sample.counts) * plate_.encoder_resolution_m);
      record.force_N.push_back(force_N);
    }
    record.pulse_s = static_cast<double>(turned) * plate_.tick_s;
    record.pulse_N = pushed_N;
  }

  /// What is staged, again: after a change of an object beside model and axis.
  std::string applied() {
    if (const auto refused = apply_staged(drive_, drive_.read(kModelIndex, 1)))
      return fmt::format("the drive refuses its own parameters (result {}, 2140h:04)", *refused);
    return "";
  }

  AxisRecord streamed(const SetPoints& motion) {
    const Used used(*this);
    AxisRecord record;
    record.rate_Hz = 1e3 / stream_.period_ms();
    if (!is_enabled(drive_)) drive_.write(0x2403, 0, kStreamTimeOut_ms, 2);
    if (!enable(kCyclicPosition)) return stopped(std::move(record));
    const double held_m = resting_m();
    const double shift_m = held_m - motion.position_m.front();
    if (std::fabs(shift_m) > kFarthestShift_m) {
      record.fault = "the motion does not begin where the axis is held";
      off();
      return record;
    }
    const std::vector<std::int32_t> set_points = counts_of(motion, shift_m);
    const StreamedMotion done = stream_.follow(set_points, limit_A_, plate_.tick_s);
    take(record, done);
    if (done.disabled || faulted()) return stopped(std::move(record));
    return checked(std::move(record), set_points);
  }

  /// Where the reference is when it no longer moves.
  double resting_m() {
    double before_m = counts_m(0x2200, 9);
    for (int i = 0; i < kRest_ms; ++i) {
      wait_ms(2);
      const double now_m = counts_m(0x2200, 9);
      if (now_m == before_m) break;
      before_m = now_m;
    }
    return before_m;
  }

  std::vector<std::int32_t> counts_of(const SetPoints& motion, double shift_m) const {
    std::vector<std::int32_t> counts;
    const double step = motion.rate_Hz * 1e-3 * stream_.period_ms();
    for (double at = 0.0; at < static_cast<double>(motion.size()) - 0.5; at += step) {
      const auto place = std::min(static_cast<std::size_t>(std::lround(at)), motion.size() - 1);
      counts.push_back(static_cast<std::int32_t>(
          std::lround((motion.position_m[place] + shift_m) / plate_.encoder_resolution_m)));
    }
    return counts;
  }

  void take(AxisRecord& record, const StreamedMotion& done) const {
    const double period_ticks = 1e-3 * stream_.period_ms() / plate_.tick_s;
    bool irregular = false;
    for (std::size_t i = 0; i < done.samples.size(); ++i) {
      const SyncSample& sample = done.samples[i];
      record.position_m.push_back(sample.counts * plate_.encoder_resolution_m);
      record.force_N.push_back(sample.current_A * plate_.motor_constant_N_per_A);
      record.reference_m.push_back(sample.reference_counts * plate_.encoder_resolution_m);
      record.error_m.push_back(sample.error_m);
      const auto ticks = static_cast<double>(sample.tick - done.samples.front().tick);
      record.time_s.push_back(ticks * plate_.tick_s);
      irregular |= std::fabs(ticks - static_cast<double>(i) * period_ticks) > 0.5;
    }
    if (!irregular) record.time_s.clear();
    record.limited_share = done.limited_share;
  }

  /// A motion that ended without a fault, but perhaps not where it should.
  AxisRecord checked(AxisRecord record, const std::vector<std::int32_t>& set_points) {
    const double end_m = set_points.back() * plate_.encoder_resolution_m;
    const double off_m = record.reference_m.empty() ? 1.0 : std::fabs(record.reference_m.back() - end_m);
    const double all = static_cast<double>(set_points.size());
    if (off_m > std::max(kArrived_m, 2.0 * plate_.encoder_resolution_m)) {
      const std::uint32_t inputs = drive_.read(0x60FD, 0);
      record.limit_switch = (inputs & 3U) != 0 || (drive_.read(0x6041, 0) & 0x800U) != 0;
      record.fault =
          fmt::format("the axis was stopped at {:.1f} mm {}", 1e3 * counts_m(0x6063, 0),
                      (inputs & 3U) != 0    ? "by a limit switch"
                      : record.limit_switch ? "by a limit of the drive (607Dh, 607Fh, 60C5h, 6080h)"
                                            : "and does not follow its set-points");
      off();
    } else if (static_cast<double>(record.position_m.size()) < (1.0 - kMostLost) * all) {
      record.fault = fmt::format("{:.1f} % of the samples were lost on the bus; ask for fewer (--period)",
                                 100.0 - 100.0 * static_cast<double>(record.position_m.size()) / all);
      off();
    }
    return record;
  }

  AxisRecord stopped(AxisRecord record) {
    for (int i = 0; i < kLongestWait_ms && (drive_.read(0x6041, 0) & 0x4FU) == 0x0F; ++i) wait_ms(1);
    const std::uint32_t error = drive_.read(0x603F, 0);
    record.lost_hold = error == error_code(Fault::kFollowingError) ||
                       error == error_code(Fault::kOverspeed) || error == error_code(Fault::kStall);
    record.fault = error == 0 ? std::string("the drive cannot be enabled, or was disabled by somebody else")
                              : fmt::format("the drive stopped with fault {:04X}h at {:.1f} mm", error,
                                            1e3 * counts_m(0x6063, 0));
    off();
    return record;
  }

  static constexpr std::int32_t kTurnedCounts = 3;

  SdoClient& drive_;
  DriveMemory memory_;
  CyclicStream stream_;
  json kept_;
  DriveBefore before_;
  Nameplate plate_;
  double rated_N_ = 0.0;
  double limit_A_ = 0.0;
  double used_s_ = 0.0;
  bool pushed_ = false;
  bool late_ = false;  // the last pulse ended because the master was silent
};

}  // namespace

std::string drive_title(SdoClient& drive) {
  require_slipstack_drive(drive);
  return fmt::format("drive {:08x}", drive.read(0x1018, 4));
}

std::unique_ptr<LiveAxis> can_axis(SdoClient& drive, const BusAxis& told, DriveMemory memory) {
  return std::make_unique<CanAxis>(drive, told, std::move(memory));
}

}  // namespace slipstack::workbench
