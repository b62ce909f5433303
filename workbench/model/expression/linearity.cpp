// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/linearity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "workbench/model/expression/expression.h"

namespace slipstack::workbench {
namespace {

constexpr int kTrials = 200;
constexpr double kTolerance = 1e-9;  ///< relative to the largest of the compared values

bool is_acceleration(const std::string& unit) {
  return unit == "m/s2" || unit == "m/s^2";
}

/// An instant and values of all parameters at which the expression is evaluated.
struct Trial {
  Instant instant;
  std::vector<double> values;
};

/// Draws trials at which expressions for an axis are likely to be non-zero: near the positions and speeds
/// that the parameters give.
class Trials {
 public:
  explicit Trials(const Definition& definition) : definition_(definition) {}

  Trial draw() {
    Trial trial;
    for (const DeclaredParameter& parameter : definition_.parameters)
      trial.values.push_back(value(parameter));
    trial.instant.t = uniform(0.0, 10.0);
    trial.instant.x = near("m", trial.values, 0.5);
    trial.instant.v = near("m/s", trial.values, 1.0);
    trial.instant.a = uniform(-10.0, 10.0);
    return trial;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  double value(const DeclaredParameter& parameter) {
    if (parameter.bounds) {
      const auto [lower, upper] = *parameter.bounds;
      return lower > 0.0 ? lower * std::pow(upper / lower, uniform(0.0, 1.0)) : uniform(lower, upper);
    }
    if (parameter.unit == "s") return uniform(0.01, 10.0);
    if (is_acceleration(parameter.unit)) return uniform(-10.0, 10.0);
    return uniform(-1.0, 1.0);
  }

  /// Mostly near the parameters of that unit: at one of them, with an offset of up to 1.5 times another.
  double near(std::string_view unit, const std::vector<double>& values, double range) {
    std::vector<double> same_unit;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (definition_.parameters[i].unit == unit) same_unit.push_back(values[i]);
    }
    const double anywhere = uniform(-range, range) * std::pow(10.0, uniform(-3.0, 0.0));
    if (same_unit.empty() || uniform(0.0, 1.0) < 0.3) return anywhere;
    const auto pick = [&] {
      return same_unit[std::uniform_int_distribution<std::size_t>(0, same_unit.size() - 1)(random_)];
    };
    return pick() + pick() * uniform(-1.5, 1.5);
  }

  const Definition& definition_;
  std::mt19937_64 random_{20260117};
};

/// Examines the expression as a function of one or two parameters, at many trials.
class Probe {
 public:
  explicit Probe(const Definition& definition) : definition_(definition), expression_(definition) {
    Trials trials(definition);
    for (int i = 0; i < kTrials; ++i) trials_.push_back(trials.draw());
  }

  /// Whether the expression is an affine, not constant, function of the parameter.
  bool affine(std::size_t p) {
    const auto [low, middle, high] = values_along(p);
    bool changes = false;
    for (const Trial& trial : trials_) {
      const double f0 = at(trial, p, low), f1 = at(trial, p, middle), f2 = at(trial, p, high);
      if (!finite({f0, f1, f2})) continue;
      const double line = f0 + (f2 - f0) * (middle - low) / (high - low);
      const double size = std::max({std::abs(f0), std::abs(f1), std::abs(f2)});
      if (std::abs(f1 - line) > kTolerance * size) return false;
      changes = changes || std::abs(f2 - f0) > kTolerance * size;
    }
    return changes;
  }

  /// Whether two parameters, in each of which the expression is affine, do not multiply each other.
  bool additive(std::size_t p, std::size_t q) {
    const auto along_p = values_along(p);
    const auto along_q = values_along(q);
    for (const Trial& trial : trials_) {
      const auto f = [&](double value_p, double value_q) {
        Trial moved = trial;
        moved.values[p] = value_p;
        moved.values[q] = value_q;
        return value(moved);
      };
      const double f00 = f(along_p[0], along_q[0]), f02 = f(along_p[0], along_q[2]),
                   f20 = f(along_p[2], along_q[0]), f22 = f(along_p[2], along_q[2]);
      if (!finite({f00, f02, f20, f22})) continue;
      const double size = std::max({std::abs(f00), std::abs(f02), std::abs(f20), std::abs(f22)});
      if (std::abs(f22 - f20 - f02 + f00) > kTolerance * size) return false;
    }
    return true;
  }

  /// Whether the expression vanishes when these parameters are zero.
  bool vanishes_without(const std::vector<std::size_t>& parameters) {
    for (const Trial& trial : trials_) {
      Trial without = trial;
      for (const std::size_t p : parameters) without.values[p] = 0.0;
      const double with = value(trial);
      const double rest = value(without);
      if (!finite({with, rest})) continue;
      if (std::abs(rest) > kTolerance * std::max(1.0, std::abs(with))) return false;
    }
    return true;
  }

  bool defined_somewhere() {
    return std::any_of(trials_.begin(), trials_.end(),
                       [&](const Trial& trial) { return std::isfinite(value(trial)); });
  }

 private:
  std::array<double, 3> values_along(std::size_t p) const {
    const auto& bounds = definition_.parameters[p].bounds;
    if (!bounds) return {-1.0, 0.7, 2.0};
    return {bounds->lower, bounds->lower + 0.4 * (bounds->upper - bounds->lower), bounds->upper};
  }
  double at(const Trial& trial, std::size_t p, double parameter_value) {
    Trial moved = trial;
    moved.values[p] = parameter_value;
    return value(moved);
  }
  double value(const Trial& trial) {
    for (std::size_t i = 0; i < trial.values.size(); ++i) expression_.set(i, trial.values[i]);
    return expression_.at(trial.instant);
  }
  static bool finite(std::initializer_list<double> values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }

  const Definition& definition_;
  Expression expression_;
  std::vector<Trial> trials_;
};

/// The largest set of parameters in which the expression is jointly linear and without which it vanishes.
/// Sets are grown greedily, starting from each parameter in turn.
std::vector<std::size_t> gains_of(Probe& probe, const std::vector<std::size_t>& affine) {
  std::vector<std::size_t> best;
  for (std::size_t first = 0; first < affine.size(); ++first) {
    std::vector<std::size_t> gains;
    for (std::size_t i = 0; i < affine.size(); ++i) {
      const std::size_t p = affine[(first + i) % affine.size()];
      const bool joins =
          std::all_of(gains.begin(), gains.end(), [&](std::size_t gain) { return probe.additive(gain, p); });
      if (joins) gains.push_back(p);
    }
    if (gains.size() > best.size() && probe.vanishes_without(gains)) best = gains;
  }
  std::sort(best.begin(), best.end());
  return best;
}

/// Position at which a parameter is first used.
std::size_t first_use(const Definition& definition, const std::string& name) {
  for (const NameInText& use : names_in(definition.expression)) {
    if (use.name == name) return definition.expression_at + use.at;
  }
  return definition.expression_at;
}

[[noreturn]] void fail_without_gain(const Definition& definition, const std::vector<std::size_t>& affine) {
  if (definition.parameters.empty()) {
    throw DefinitionError("no parameter; the fit needs a gain, as in 'A*(...); A: N'", definition.text,
                          definition.expression_at);
  }
  if (affine.empty()) {
    // The message names the first parameter that has the unit of a force.
    const auto& all = definition.parameters;
    const auto force =
        std::find_if(all.begin(), all.end(), [](const auto& one) { return one.unit.starts_with("N"); });
    const DeclaredParameter& blamed = force == all.end() ? all.front() : *force;
    throw DefinitionError(
        fmt::format("'{}' does not enter linearly, and no other parameter does; a gain multiplies the rest, "
                    "as in 'A*(...); A: N'",
                    blamed.name),
        definition.text, first_use(definition, blamed.name));
  }
  throw DefinitionError(
      "a part of the expression is multiplied by no gain; give every term one, as in 'A*(...) + B*(...)'",
      definition.text, definition.expression_at);
}

}  // namespace

bool range_from_log(const std::string& unit) {
  return unit == "m" || unit == "m/s" || unit == "s" || is_acceleration(unit);
}

ParameterRoles roles_of(const Definition& definition) {
  Probe probe(definition);
  if (!probe.defined_somewhere()) {
    throw DefinitionError("the expression is not a finite number anywhere", definition.text,
                          definition.expression_at);
  }
  std::vector<std::size_t> affine;
  for (std::size_t p = 0; p < definition.parameters.size(); ++p) {
    if (probe.affine(p)) affine.push_back(p);
  }
  ParameterRoles roles;
  roles.gains = gains_of(probe, affine);
  if (roles.gains.empty()) fail_without_gain(definition, affine);
  for (std::size_t p = 0; p < definition.parameters.size(); ++p) {
    if (std::find(roles.gains.begin(), roles.gains.end(), p) != roles.gains.end()) continue;
    const DeclaredParameter& parameter = definition.parameters[p];
    const bool is_affine = std::find(affine.begin(), affine.end(), p) != affine.end();
    if (is_affine && probe.vanishes_without({p})) {
      throw DefinitionError(
          fmt::format("'{}' only scales the others, and no log can separate them; leave it out",
                      parameter.name),
          definition.text, parameter.at);
    }
    if (!parameter.bounds && !range_from_log(parameter.unit)) {
      throw DefinitionError(
          fmt::format("'{0}' does not enter linearly, so it is searched and needs bounds: '{0}: {1} in "
                      "[low, high]'",
                      parameter.name, parameter.unit),
          definition.text, parameter.at);
    }
    roles.shapes.push_back(p);
  }
  return roles;
}

}  // namespace slipstack::workbench
