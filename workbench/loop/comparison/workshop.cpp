// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/workshop.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "firmware/effects/catalogue.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/frequency/rigid_mass.h"
#include "workbench/loop/loop_parameters.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/report/fitted_model_file.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kTicksPerSample = 5;  // of the training log: 2 kHz
constexpr double kTraining_s = 16.0;
constexpr double kLoopTraining_s = 6.0;  // of it, for what is searched in the loop
constexpr int kLoopSearches = 14;
constexpr int kRepetitions = 10;
constexpr double kFinestEncoder_m = 1e-9;  // with which the axis may still move at 2 m/s

AxisParameters with_tuned_feedback(const sim::Axis& axis) {
  AxisParameters parameters = loop_parameters(axis, kComparedTick_s);
  const DriveController gains = feedback_for_mass(
      axis.mass_kg, kComparedTick_s, static_cast<double>(parameters.observer_bandwidth_rad_per_s), {});
  parameters.position_gain_per_s = static_cast<float>(gains.position_gain_per_s);
  parameters.velocity_gain_N_s_per_m = static_cast<float>(gains.velocity_gain_N_s_per_m);
  parameters.integral_per_s = static_cast<float>(gains.integral_per_s);
  return parameters;
}

// ---- the log of the training motion ----

/// A drive reports its command; at a sample, the mean of the commands before and after it.
Log training_log(const sim::Axis& axis, const DriveRun& run) {
  Log log;
  log.path = "training";
  log.sample_rate_Hz = 1.0 / (kComparedTick_s * static_cast<double>(kTicksPerSample));
  for (std::size_t i = 1; i < run.force_N.size(); i += kTicksPerSample) {
    log.position_m.push_back(run.counts_m[i]);
    log.force_N.push_back(0.5 * (run.force_N[i - 1] + run.force_N[i]));
  }
  log.motor_constant_N_per_A = axis.motor_constant_N_per_A;
  log.magnet_pitch_m = axis.magnet_pitch_m;
  log.encoder_resolution_m = axis.encoder_resolution_m;
  log.commanded_current = true;
  return log;
}

// ---- the models ----

/// Between which lengths pre-sliding was found, m: the elements of the whole fit that carry something.
std::pair<double, double> presliding_lengths(const FittedModel& fitted) {
  std::pair<double, double> lengths{0.0, 0.0};
  for (const Term& term : fitted.terms) {
    if (!term.effect->has_role(Role::hysteresis)) continue;
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      if (!(term.gains[i] > 0.0)) continue;
      lengths.first = lengths.first > 0.0 ? std::min(lengths.first, term.shapes[i]) : term.shapes[i];
      lengths.second = std::max(lengths.second, term.shapes[i]);
    }
  }
  return lengths;
}

FrictionFit fitted_friction(FrictionKind kind, const Measurement& measurement, double shortest_m,
                            double longest_m) {
  FrictionData data;
  data.motion = {measurement.tick_s(), measurement.position_m(), measurement.velocity_mps(), shortest_m,
                 longest_m};
  data.force_N = measurement.force_N();
  data.others.push_back(measurement.acceleration_mps2());
  data.observe = [&](std::span<const double> signal) { return measurement.filtered(signal); };
  return fit_friction(kind, data);
}

/// The elements of a model with few of them stand the denser the shorter the range: the beginning of the
/// range that fits best.
FrictionFit best_fitted_friction(FrictionKind kind, const Measurement& measurement, double shortest_m,
                                 double longest_m) {
  constexpr double kRatio = 3.0;
  constexpr double kDecade = 10.0;  // the range keeps at least one
  FrictionFit best = fitted_friction(kind, measurement, shortest_m, longest_m);
  if (best.slips_m.empty()) return best;
  for (double from_m = kRatio * shortest_m; kDecade * from_m < longest_m; from_m *= kRatio) {
    FrictionFit other = fitted_friction(kind, measurement, from_m, longest_m);
    if (other.relative_error < best.relative_error) best = std::move(other);
  }
  return best;
}

ModelParameters refined_model(const Measurement& measurement, const FittedModel& fitted) {
  return target_parameters(on_controller(measurement, refine_nominal_shapes(measurement, fitted)).terms);
}

std::vector<std::string> effects_with(const std::vector<std::string>& more) {
  std::vector<std::string> effects = default_baseline();
  effects.insert(effects.end(), {Viscous<float>::text.id, OffsetForce<float>::text.id});
  effects.insert(effects.end(), more.begin(), more.end());
  return effects;
}

ShapeRange range_of(std::size_t index, double lower, double upper, bool logarithmic) {
  ShapeRange range{};
  range.index = index;
  range.lower = lower;
  range.upper = upper;
  range.logarithmic = logarithmic;
  return range;
}

Measurement recorded(const sim::Axis& axis, const AxisParameters& parameters, std::uint64_t seed) {
  const Trajectory training = training_motion(axis, seed, kTraining_s, kComparedTick_s);
  const ComparedDrive drive(axis, parameters, mass_only_model(axis.mass_kg), seed);
  const DriveRun run = drive.run(training, {});
  if (run.lost) throw std::runtime_error("the axis does not follow the training motion");
  // A velocity table needs the frequencies of the reversals; the band in which the encoder's steps do not
  // matter ends far below them.
  const Log log = training_log(axis, run);
  Measurement measurement(log, {.bandwidth_Hz = kHighestBandwidth * log.sample_rate_Hz});
  weigh_rows(measurement);
  return measurement;
}

}  // namespace

Workshop::Workshop(const sim::Axis& axis, std::uint64_t seed)
    : axis_(axis),
      seed_(seed),
      parameters_(with_tuned_feedback(axis)),
      measurement_(recorded(axis, parameters_, seed)),
      loop_training_(training_motion(axis, seed, kLoopTraining_s, kComparedTick_s)) {
  const FittedModel base = fit_effects(measurement_, effects_with({}), {});
  mass_kg_ = mass_kg(base.terms);
  lengths_m_ = presliding_lengths(base);
  own_model_ = refined_model(measurement_, base);
}

// The least rms error on the training motion.
void Workshop::search_in_loop(Contender& contender, const std::vector<double Contender::*>& parameters,
                              const std::vector<ShapeRange>& ranges) const {
  const auto with = [&](const std::vector<double>& values) {
    Contender other = contender;
    for (std::size_t i = 0; i < parameters.size(); ++i) other.*parameters[i] = values[i];
    return other;
  };
  const auto cost = [&](const std::vector<double>& values) {
    const DriveRun tried = run(with(values), axis_, loop_training_, seed_);
    return tried.lost ? 1.0 : rms(tried.error_m);
  };
  std::vector<double> start;
  start.reserve(parameters.size());
  for (double Contender::*parameter : parameters) start.push_back(contender.*parameter);
  contender = with(refine_shapes(ranges, start, cost, {kLoopSearches}).shapes);
}

Contender Workshop::plain(const ContenderName& name) const {
  Contender contender;
  contender.name = name;
  contender.axis = parameters_;
  contender.model = mass_only_model(mass_kg_);
  return contender;
}

Contender Workshop::without_mass(const ContenderName& name) const {
  Contender contender = plain(name);
  contender.mass_share = 0.0;
  return contender;
}

Contender Workshop::with_friction(FrictionKind kind, const ContenderName& name) const {
  Contender contender = plain(name);
  contender.friction = best_fitted_friction(kind, measurement_, lengths_m_.first, lengths_m_.second);
  // The last gains are those of the acceleration and of the offset.
  const Eigen::VectorXd& gains = contender.friction->gains;
  contender.model = mass_only_model(gains[gains.size() - 2]);
  search_in_loop(contender, {&Contender::level}, {range_of(0, 0.5, 1.5, false)});
  return contender;
}

Contender Workshop::with_observer(Contender contender) const {
  contender.observer_share = 0.5;
  search_in_loop(contender, {&Contender::observer_share}, {range_of(0, 0.0, 1.0, false)});
  return contender;
}

Contender Workshop::learning(const ContenderName& name) const {
  Contender contender = plain(name);
  contender.repetitions = kRepetitions;
  contender.learning_gain = 0.7;
  contender.learning_cutoff_Hz = 80.0;
  search_in_loop(contender, {&Contender::learning_gain, &Contender::learning_cutoff_Hz},
                 {range_of(0, 0.1, 1.0, false), range_of(1, 10.0, 300.0, true)});
  return contender;
}

Contender Workshop::maxwell_slip(const ContenderName& name, const std::vector<std::string>& more) const {
  Contender contender = plain(name);
  contender.own_model = true;
  contender.model = more.empty()
                        ? own_model_
                        : refined_model(measurement_, fit_effects(measurement_, effects_with(more), {}));
  return contender;
}

Contender Workshop::diagnosed(const ContenderName& name) const {
  Contender contender = plain(name);
  contender.own_model = true;
  Measurement measurement = measurement_;  // the search lowers its noise floor
  DiagnoseOptions options;
  options.baseline = effects_with({});
  contender.model = refined_model(measurement, diagnose(measurement, options).explained);
  return contender;
}

Contender Workshop::bound(const ContenderName& name, double noise_share, double encoder_share) const {
  Contender contender = plain(name);
  contender.model = mass_only_model(axis_.mass_kg);
  contender.noise_share = noise_share;
  contender.encoder_share =
      std::max(encoder_share, std::min(1.0, kFinestEncoder_m / axis_.encoder_resolution_m));
  return contender;
}

}  // namespace slipstack::workbench
