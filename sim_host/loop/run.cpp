// SPDX-License-Identifier: Apache-2.0
#include "sim_host/loop/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "sim_host/loop/set_points.h"
#include "sim_host/plant/plant.h"

namespace slipstack::sim {

namespace {

// States and commands of CiA 402, as PlantLink::state and control_word carry them.
constexpr std::uint32_t kOperationEnabled = 4;
constexpr std::array<std::uint32_t, 4> kToOperationEnabled = {0x00, 0x06, 0x07, 0x0F};
constexpr std::int64_t kTicksPerReport = 20000;
constexpr std::int64_t kTicksPerTiming = 7;

class Runner {
 public:
  Runner(LockstepBoard& board, const Axis& axis, const MotionProgramme& programme, const LoopOptions& options)
      : board_(board),
        link_(board.link()),
        axis_(axis),
        programme_(programme),
        options_(options),
        plant_(axis, programme.at(0.0).x_m),
        per_sample_(std::max(1, static_cast<int>(std::lround(1.0 / (options.tick_s * options.log_rate_Hz))))),
        recorder_(axis, 1.0 / (options.tick_s * per_sample_), per_sample_, false,
                  Rng(options.seed, "noise")) {}

  LoopResult run(const std::function<void(double)>& progress) {
    const auto begin = std::chrono::steady_clock::now();
    link_.period = static_cast<std::uint32_t>(std::lround(options_.tick_s * PlantLink::kClockTicks_Hz));
    link_.encoder_valid = 1;
    link_.current_valid = 1;
    link_.parameter_sequence = link_.parameter_sequence + 1;
    enable();
    const auto count = static_cast<std::int64_t>(std::ceil(programme_.duration_s() / options_.tick_s));
    recorder_.reserve(static_cast<std::size_t>(count / per_sample_ + 1));
    for (std::int64_t i = 0; i < count && !result_.stopped_by_fault; ++i) {
      if (i % kTicksPerReport == 0) progress(static_cast<double>(i) / static_cast<double>(count));
      const auto before = std::chrono::steady_clock::now();
      send_set_points(i);
      turn(true);
      if (i % kTicksPerTiming != 0) continue;
      turns_s_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
    }
    if (!turns_s_.empty()) {
      const auto middle = turns_s_.begin() + static_cast<std::ptrdiff_t>(turns_s_.size() / 2);
      std::nth_element(turns_s_.begin(), middle, turns_s_.end());
      result_.median_round_trip_s = *middle;
    }
    result_.log = recorder_.finish();
    result_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result_.rms_error_m = std::sqrt(squares_ / static_cast<double>(std::max<std::int64_t>(1, result_.ticks)));
    result_.rms_reversal_error_m =
        std::sqrt(reversal_squares_ / static_cast<double>(std::max<std::int64_t>(1, reversal_ticks_)));
    return result_;
  }

 private:
  void enable() {
    turn(false);
    if (link_.last_status != 0) {
      throw LoopError(link_.last_status == 255
                          ? std::string("the image is of another version than this program; build both anew")
                          : fmt::format("the controller refuses its parameters (status {})",
                                        static_cast<std::uint32_t>(link_.last_status)));
    }
    for (const std::uint32_t word : kToOperationEnabled) {
      link_.control_word = word;
      for (int i = 0; i < 3; ++i) turn(false);
    }
    if (link_.state != kOperationEnabled) {
      throw LoopError(fmt::format("the controller is not enabled: state {}, fault {}",
                                  static_cast<std::uint32_t>(link_.state),
                                  static_cast<std::uint32_t>(link_.fault)));
    }
  }

  // One set-point every period; the first ones without delay, so that the controller always holds some.
  void send_set_points(std::int64_t tick) {
    const auto period = static_cast<std::int64_t>(options_.stream_period_ticks);
    if (tick >= kSetPointsAhead && tick % period != 0) return;
    const double place =
        programme_.at(static_cast<double>(sent_) * static_cast<double>(period) * options_.tick_s).x_m /
        axis_.encoder_resolution_m;
    ++sent_;
    if (sent_ == 1) offset_counts_ = static_cast<double>(link_.reference_counts) - std::floor(place);
    const double whole = std::floor(place);
    send_set_point(link_, static_cast<std::int64_t>(whole + offset_counts_), place - whole,
                   static_cast<std::uint32_t>(options_.stream_period_ticks));
  }

  void turn(bool recorded) {
    const double t_s = static_cast<double>(result_.ticks) * options_.tick_s;
    const Encoder& encoder = recorder_.encoder();
    link_.counts = static_cast<std::int32_t>(encoder.counts(plant_.position_m(), recorded ? t_s : 0.0));
    board_.tick();
    const double current_A = link_.driving != 0 ? static_cast<double>(link_.current_A) : 0.0;
    const double disturbance_N = recorder_.draw_noise_N() + options_.push_N;
    if (recorded) record(current_A, disturbance_N);
    plant_.step(current_A, options_.tick_s, disturbance_N);
    if (!(std::fabs(plant_.position_m() - programme_.at(0.0).x_m) < 10.0 * axis_.stroke_m) ||
        !(std::fabs(plant_.velocity_mps()) < 100.0)) {
      throw LoopError(fmt::format(
          "the plant diverges at {:.4f} s: {:.3g} m, {:.3g} m/s; weaken what drives it (--push, --strength, "
          "the model's gains)",
          t_s, plant_.position_m(), plant_.velocity_mps()));
    }
  }

  // A drive reports its command: noise and constant force move the axis but are not part of the log.
  void record(double current_A, double disturbance_N) {
    const bool logged = recorder_.logs_next();
    // The command is held from here on; at this instant the current is taken as the mean of the commands
    // before and after it.
    const double mean_A = 0.5 * (last_A_ + current_A);
    last_A_ = current_A;
    recorder_.push(plant_.position_m(), plant_.parts(mean_A, disturbance_N), -disturbance_N);
    if (logged)
      recorder_.add_reference(static_cast<double>(link_.reference_counts) * axis_.encoder_resolution_m);
    ++result_.ticks;
    result_.stopped_by_fault = link_.fault != 0;
    if (result_.stopped_by_fault) return;
    const double error_m = static_cast<double>(link_.position_error_m);
    squares_ += error_m * error_m;
    result_.peak_error_m = std::max(result_.peak_error_m, std::fabs(error_m));
    result_.peak_current_A = std::max(result_.peak_current_A, std::fabs(current_A));
    result_.largest_residual_N =
        std::max(result_.largest_residual_N, std::fabs(static_cast<double>(link_.residual_N)));
    note_reversal();
    if (since_reversal_ * options_.tick_s < 0.05) {
      reversal_squares_ += error_m * error_m;
      ++reversal_ticks_;
    }
  }

  // A reversal of the reference: its direction changes, with or without a dwell in between.
  void note_reversal() {
    const std::int32_t moved = link_.reference_counts - last_reference_;
    last_reference_ = link_.reference_counts;
    ++since_reversal_;
    if (moved == 0) return;
    const int direction = moved > 0 ? 1 : -1;
    if (direction_ != 0 && direction != direction_) since_reversal_ = 0;
    direction_ = direction;
  }

  LockstepBoard& board_;
  PlantLink& link_;
  const Axis& axis_;
  const MotionProgramme& programme_;
  const LoopOptions& options_;
  Plant plant_;
  int per_sample_;
  Recorder recorder_;
  LoopResult result_;
  std::int64_t sent_ = 0;
  double offset_counts_ = 0.0;
  std::vector<double> turns_s_;
  double last_A_ = 0.0;
  double squares_ = 0.0;
  double reversal_squares_ = 0.0;
  std::int64_t reversal_ticks_ = 0;
  double since_reversal_ = 1e9;
  std::int32_t last_reference_ = 0;
  int direction_ = 0;
};

}  // namespace

LoopResult run_loop(LockstepBoard& board, const Axis& axis, const MotionProgramme& programme,
                    const LoopOptions& options, const std::function<void(double)>& progress) {
  return Runner(board, axis, programme, options).run(progress);
}

}  // namespace slipstack::sim
