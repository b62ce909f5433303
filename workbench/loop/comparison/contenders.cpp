// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/contenders.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "firmware/effects/catalogue.h"
#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
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

ModelParameters model_with_mass(double mass_kg) {
  ModelParameters model{};
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  inertia.enabled = true;
  inertia.gains[0] = static_cast<float>(mass_kg);
  return model;
}

FrictionFit fitted_friction(FrictionKind kind, const sim::Axis& axis, const Measurement& measurement) {
  FrictionData data;
  data.motion = {measurement.tick_s(), measurement.position_m(), measurement.velocity_mps(),
                 axis.encoder_resolution_m, 1e-3};
  data.force_N = measurement.force_N();
  data.others.push_back(measurement.acceleration_mps2());
  data.observe = [&](std::span<const double> signal) { return measurement.filtered(signal); };
  return fit_friction(kind, data);
}

ModelParameters fitted_model(const Measurement& measurement, const std::vector<std::string>& effects) {
  const FittedModel fitted = refine_nominal_shapes(measurement, fit_effects(measurement, effects, {}));
  return target_parameters(on_controller(measurement, fitted).terms);
}

std::vector<std::string> effects_with(std::vector<std::string> more) {
  std::vector<std::string> effects = default_baseline();
  effects.insert(effects.end(), {Viscous<float>::text.id, OffsetForce<float>::text.id});
  effects.insert(effects.end(), more.begin(), more.end());
  return effects;
}

// ---- what is searched in the loop ----

/// The least rms error on the training motion.
void search_in_loop(Contender& contender, const std::vector<double Contender::*>& parameters,
                    const std::vector<ShapeRange>& ranges, const sim::Axis& axis, const Trajectory& training,
                    std::uint64_t seed) {
  const auto with = [&](const std::vector<double>& values) {
    Contender other = contender;
    for (std::size_t i = 0; i < parameters.size(); ++i) other.*parameters[i] = values[i];
    return other;
  };
  const auto cost = [&](const std::vector<double>& values) {
    const DriveRun tried = run(with(values), axis, training, seed);
    return tried.lost ? 1.0 : rms(tried.error_m);
  };
  std::vector<double> start;
  start.reserve(parameters.size());
  for (double Contender::*parameter : parameters) start.push_back(contender.*parameter);
  contender = with(refine_shapes(ranges, start, cost, kLoopSearches).shapes);
}

ShapeRange range_of(std::size_t index, double lower, double upper, bool logarithmic) {
  ShapeRange range{};
  range.index = index;
  range.lower = lower;
  range.upper = upper;
  range.logarithmic = logarithmic;
  return range;
}

/// What every contender is made from.
struct Workshop {
  const sim::Axis& axis;
  std::uint64_t seed;
  AxisParameters parameters;
  double mass_kg;
  const Measurement& measurement;
  Trajectory loop_training;

  Contender plain(const std::string& id, const std::string& title, const std::string& strength) const {
    Contender contender;
    contender.id = id;
    contender.title = title;
    contender.strength = strength;
    contender.axis = parameters;
    contender.model = model_with_mass(mass_kg);
    return contender;
  }

  Contender with_friction(FrictionKind kind, const std::string& title, const std::string& strength) const {
    Contender contender = plain(std::string(name(kind)), title, strength);
    contender.friction = fitted_friction(kind, axis, measurement);
    // The last gains are those of the acceleration and of the offset.
    const Eigen::VectorXd& gains = contender.friction->gains;
    contender.model = model_with_mass(gains[gains.size() - 2]);
    search_in_loop(contender, {&Contender::level}, {range_of(0, 0.5, 1.5, false)}, axis, loop_training, seed);
    return contender;
  }

  Contender with_observer(Contender contender) const {
    contender.observer_share = 0.5;
    search_in_loop(contender, {&Contender::observer_share}, {range_of(0, 0.0, 1.0, false)}, axis,
                   loop_training, seed);
    return contender;
  }

  Contender learning() const {
    Contender contender =
        plain("ilc", "iterative learning, 10 repetitions", "it has made this very motion nine times before");
    contender.repetitions = kRepetitions;
    contender.learning_gain = 0.7;
    contender.learning_cutoff_Hz = 80.0;
    search_in_loop(contender, {&Contender::learning_gain, &Contender::learning_cutoff_Hz},
                   {range_of(0, 0.1, 1.0, false), range_of(1, 10.0, 300.0, true)}, axis, loop_training, seed);
    return contender;
  }

  Contender maxwell_slip(const std::string& id, const std::string& title,
                         std::vector<std::string> more) const {
    Contender contender = plain(id, title, "it knows where the axis last turned round");
    contender.ours = true;
    contender.own_model = true;
    contender.model = fitted_model(measurement, effects_with(std::move(more)));
    return contender;
  }
};

using Maker = std::function<Contender(const Workshop&)>;

std::vector<Maker> makers_of(Field field) {
  using W = Workshop;
  std::vector<Maker> few = {
      [](const W& w) {
        Contender c = w.plain("p_pi", "P/PI alone", "it adds nothing that could be wrong");
        c.mass_share = 0.0;
        return c;
      },
      [](const W& w) {
        return w.plain("mass", "with mass", "it adds nothing that friction could make wrong");
      },
      [](const W& w) {
        return w.with_friction(FrictionKind::kVelocityTable, "velocity table, 20 points",
                               "far from a reversal, friction is a function of velocity");
      },
      [](const W& w) { return w.maxwell_slip("maxwell_slip", "slipstack", {}); },
  };
  if (field == Field::kFew) return few;
  const Maker ours = few.back();
  few.pop_back();
  const std::string form = "its form fits this axis as well as elements do, with fewer parameters";
  const auto add = [&](FrictionKind kind, const std::string& title, const std::string& strength) {
    few.emplace_back([=](const W& w) { return w.with_friction(kind, title, strength); });
  };
  add(FrictionKind::kCoulombStribeck, "Coulomb, Stribeck, viscous",
      "far from a reversal, friction is a function of velocity");
  add(FrictionKind::kDahl, "Dahl", form);
  add(FrictionKind::kLuGre, "LuGre", form);
  add(FrictionKind::kElastoPlastic, "elasto-plastic", form);
  add(FrictionKind::kGms, "GMS", "its elements are the same in pre-sliding");
  few.emplace_back([](const W& w) {
    Contender c =
        w.plain("observer", "disturbance observer alone", "it answers to every force, known or not");
    c.mass_share = 0.0;
    return w.with_observer(std::move(c));
  });
  few.emplace_back([](const W& w) {
    return w.with_observer(
        w.plain("observer_mass", "disturbance observer, mass", "it answers to every force, known or not"));
  });
  few.emplace_back([](const W& w) { return w.learning(); });
  few.push_back(ours);
  few.emplace_back([](const W& w) {
    return w.maxwell_slip("maxwell_slip_maps", "slipstack, maps",
                          {ForceRipple<float>::text.id, PositionDependentPreload<float>::text.id});
  });
  few.emplace_back([](const W& w) {
    Contender c = w.maxwell_slip("maxwell_slip_adapted", "slipstack, adaptation", {});
    c.axis.adapt_level = true;
    c.axis.level_memory_s = 1.0F;
    return c;
  });
  few.emplace_back([](const W& w) {
    return w.with_observer(w.maxwell_slip("maxwell_slip_observer", "slipstack, observer", {}));
  });
  return few;
}

}  // namespace

std::vector<Contender> tuned_contenders(const sim::Axis& axis, std::uint64_t seed, Field field,
                                        const std::function<void(double)>& progress) {
  const AxisParameters parameters = with_tuned_feedback(axis);
  const Trajectory training = training_motion(axis, seed, kTraining_s, kComparedTick_s);
  const ComparedDrive drive(axis, parameters, model_with_mass(axis.mass_kg), seed);
  const DriveRun recorded = drive.run(training, {});
  if (recorded.lost) throw std::runtime_error("the axis does not follow the training motion");
  Measurement measurement(training_log(axis, recorded));
  weigh_rows(measurement);
  const FittedModel base = fit_effects(measurement, effects_with({}), {});
  const Workshop workshop{axis,        seed,
                          parameters,  mass_kg(base.terms),
                          measurement, training_motion(axis, seed, kLoopTraining_s, kComparedTick_s)};
  const std::vector<Maker> makers = makers_of(field);
  std::vector<Contender> made(makers.size());
  std::atomic<std::size_t> done{0};
  parallel_for(makers.size(), [&](std::size_t i) {
    made[i] = makers[i](workshop);
    progress(static_cast<double>(++done) / static_cast<double>(makers.size()));
  });
  return made;
}

}  // namespace slipstack::workbench
