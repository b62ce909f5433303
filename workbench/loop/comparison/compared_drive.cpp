// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/compared_drive.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "sim_host/plant/plant.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/encoder.h"

namespace slipstack::workbench {
namespace {

constexpr double kPhase = 0.37;  // of the grating at which the axis is switched on, counts

std::vector<ReferencePoint> reference_of(const Trajectory& trajectory, double resolution_m) {
  std::vector<ReferencePoint> reference;
  reference.reserve(trajectory.size());
  const double per_tick = trajectory.tick_s / resolution_m;
  for (const sim::MotionPoint& at : trajectory.points) {
    const double place = at.x_m / resolution_m + kPhase;
    const double whole = std::floor(place);
    reference.push_back({static_cast<std::int32_t>(whole), static_cast<float>(place - whole),
                         static_cast<float>(at.v_mps * per_tick),
                         static_cast<float>(at.a_mps2 * per_tick * trajectory.tick_s)});
  }
  return reference;
}

/// One run.
class DriveRunner {
 public:
  DriveRunner(const sim::Axis& axis, const AxisParameters& parameters, const ModelParameters& model,
              std::uint64_t noise_seed, const std::vector<ReferencePoint>& reference, double start_m,
              const Compensation& compensation)
      : axis_(axis),
        reference_(reference),
        compensation_(compensation),
        plant_(axis, start_m),
        encoder_(axis.encoder_resolution_m, kPhase),
        noise_(noise_seed, "compared drive") {
    const ParameterStatus status = set_->prepare(parameters, model, {});
    if (status != ParameterStatus::kOk)
      throw std::invalid_argument(
          fmt::format("the controller refuses the parameters (status {})", static_cast<int>(status)));
    const std::int32_t here = counts();
    set_->forget_motion(here);
    set_->model.refresh(0.0F);
    force_.start(*set_, here);
    adaptation_.begin(set_->adaptation);
    place_.start(parameters.reference);
  }

  DriveRun run() {
    DriveRun result;
    const std::size_t size = reference_.size();
    for (auto* column :
         {&result.error_m, &result.position_m, &result.counts_m, &result.force_N, &result.feedback_N})
      column->reserve(size);
    for (std::size_t i = 0; i < size && !result.lost; ++i) step(i, result);
    result.level = static_cast<double>(adaptation_.level());
    return result;
  }

 private:
  std::int32_t counts() const { return static_cast<std::int32_t>(encoder_.counts(plant_.position_m())); }

  void step(std::size_t i, DriveRun& result) {
    ControlSet& set = *set_;
    const auto number = static_cast<std::uint32_t>(i + 1);
    const std::int32_t now = counts();
    TickHistory::Entry& entry = history_.entry(number);
    const ReferencePoint& point = entry.point = reference_[i];
    out_.limits = 0;
    out_.level = adaptation_.level();
    Command command;
    force_.observe(set, point, now, false);
    feed_forward(i, point, command);
    entry.residual = force_.note();
    const ForceControl::Tick tick{
        set, bounds_, command, history_, entry, out_, number, now, set.axis.current_limit_A, false, false};
    if (!force_.step_position(tick)) throw std::invalid_argument("the force is not finite");
    out_.driving = true;
    adaptation_.step(set.adaptation, {point.counts, point.velocity, entry.residual.dry_N,
                                      point.acceleration * set.mps2_per_count, entry.residual.residual_N});
    set.add_mass(adaptation_.added_kg());
    note(i, now, result);
    const double noise_N = axis_.force_noise_N > 0.0 ? axis_.force_noise_N * noise_.normal() : 0.0;
    plant_.step(static_cast<double>(out_.current_A), kComparedTick_s, noise_N);
  }

  // The estimate expects what the feed-forward says: where the mass is not fed forward it is still known, as
  // the mass of every drive with an estimate is, and taken away behind it.
  void feed_forward(std::size_t i, const ReferencePoint& point, Command& command) {
    ControlSet& set = *set_;
    if (compensation_.own_model) {
      out_.feedforward_N = force_.step_model(set, point, out_.level, place_);
    } else {
      const float mass_N = set.mass_kg * point.acceleration * set.mps2_per_count;
      const double friction_N = compensation_.friction_N.empty() ? 0.0 : compensation_.friction_N[i];
      out_.feedforward_N = mass_N + static_cast<float>(friction_N);
      command.offset_N = (static_cast<float>(compensation_.mass_share) - 1.0F) * mass_N;
    }
    if (compensation_.learned_N.empty()) return;
    out_.feedforward_N += static_cast<float>(compensation_.learned_N[i]);
  }

  void note(std::size_t i, std::int32_t now, DriveRun& result) const {
    const double position_m = plant_.position_m();
    const ReferencePoint& at = reference_[i];
    const double place = static_cast<double>(at.counts) + static_cast<double>(at.fraction) - kPhase;
    const double error_m = place * axis_.encoder_resolution_m - position_m;
    result.error_m.push_back(error_m);
    result.position_m.push_back(position_m);
    result.counts_m.push_back(static_cast<double>(now) * axis_.encoder_resolution_m);
    result.force_N.push_back(static_cast<double>(out_.current_A) * axis_.motor_constant_N_per_A);
    result.feedback_N.push_back(static_cast<double>(out_.feedback_N));
    result.lost = !(std::fabs(error_m) < static_cast<double>(set_->axis.following_error_m));
  }

  const sim::Axis& axis_;
  const std::vector<ReferencePoint>& reference_;
  const Compensation& compensation_;
  sim::Plant plant_;
  sim::Encoder encoder_;
  sim::Rng noise_;
  std::unique_ptr<ControlSet> set_ = std::make_unique<ControlSet>();
  MotionBounds bounds_;
  TickHistory history_;
  ControlOutput out_;
  ForceControl force_;
  Adaptation adaptation_;
  PositionReference place_;
};

}  // namespace

ComparedDrive::ComparedDrive(sim::Axis axis, const AxisParameters& parameters, const ModelParameters& model,
                             std::uint64_t noise_seed)
    : axis_(std::move(axis)), parameters_(parameters), model_(model), noise_seed_(noise_seed) {
  if (const ParameterStatus status = check(parameters, model); status != ParameterStatus::kOk)
    throw std::invalid_argument(
        fmt::format("the controller refuses the parameters (status {})", static_cast<int>(status)));
}

DriveRun ComparedDrive::run(const Trajectory& trajectory, const Compensation& compensation) const {
  return run(reference_of(trajectory, axis_.encoder_resolution_m), trajectory.points.front().x_m,
             compensation);
}

DriveRun ComparedDrive::run(const std::vector<ReferencePoint>& reference, double start_m,
                            const Compensation& compensation) const {
  return DriveRunner(axis_, parameters_, model_, noise_seed_, reference, start_m, compensation).run();
}

}  // namespace slipstack::workbench
