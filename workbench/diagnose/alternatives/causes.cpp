// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/causes.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <string>

#include "workbench/base/quantity.h"
#include "workbench/diagnose/alternatives/lines.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/nonlinear/minimise.h"

namespace slipstack::workbench {
namespace {

using std::numbers::pi;

class LineBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    rate_ = 2.0 * pi * shapes[0];
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      *out++ = std::cos(rate_ * sample.time_s);
      *out++ = std::sin(rate_ * sample.time_s);
    }
  }

 private:
  double rate_ = 0.0;
};

class ChangeBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override { from_s_ = shapes[0]; }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      const double changed = sample.time_s >= from_s_ ? 1.0 : 0.0;
      *out++ = changed;
      *out++ = changed;
    }
  }

 private:
  double from_s_ = 0.0;
};

/// Intervals between the knots of a curve over time.
constexpr int kIntervals = 40;

/// Linear B-splines over the time from the first shape to the second.
class CurveBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    first_s_ = shapes[0];
    per_s_ = kIntervals / std::max(shapes[1] - shapes[0], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      std::fill_n(out, kIntervals + 1, 0.0);
      const double at = std::clamp((sample.time_s - first_s_) * per_s_, 0.0, kIntervals - 1e-9);
      const auto knot = static_cast<std::ptrdiff_t>(at);
      out[knot] = 1.0 - (at - static_cast<double>(knot));
      out[knot + 1] = at - static_cast<double>(knot);
      out += kIntervals + 1;
    }
  }

 private:
  double first_s_ = 0.0;
  double per_s_ = 1.0;
};

/// The basis of a force at one place, for a position in half widths from its middle: two forces, and a factor
/// of the dry friction.
std::array<double, 3> place_columns(double from_middle) {
  if (std::abs(from_middle) >= 1.0) return {};
  const double window = 0.5 * (1.0 + std::cos(pi * from_middle));
  return {window, window * std::sin(pi * from_middle), window};
}

class PlaceBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    middle_m_ = shapes[0];
    half_width_m_ = std::max(shapes[1], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      const auto columns = place_columns((sample.position_m - middle_m_) / half_width_m_);
      out = std::copy(columns.begin(), columns.end(), out);
    }
  }

 private:
  double middle_m_ = 0.0;
  double half_width_m_ = 1.0;
};

/// The description of a cause; its shapes are found by shapes_of_cause() and not searched.
template <class Basis>
EffectDescription cause(const char* id, std::vector<GainGroup> gains, std::vector<ShapeSpec> shapes) {
  EffectDescription description;
  description.text = {.id = id,
                      .title = id,
                      .formula = "",
                      .source = "",
                      .residual = "",
                      .evidence = "",
                      .cause = "",
                      .confirm = ""};
  for (ShapeSpec& shape : shapes) shape.kind = ShapeKind::table;
  for (const GainGroup& group : gains) description.gain_count += group.count;
  description.gain_groups = std::move(gains);
  description.shapes = std::move(shapes);
  description.traits.plannable = false;
  description.traits.per_log = std::is_same_v<Basis, LineBasis>;  // the phase differs from log to log
  description.make = [] { return std::make_unique<Basis>(); };
  return description;
}

GainGroup any_force(const char* name) {
  return {name, "N", -kUnbounded, kUnbounded, 1, Acts::force};
}

ShapeSpec found(const char* name, const char* unit) {
  return {name, unit, -kUnbounded, kUnbounded, ShapeKind::table};
}

const std::array<EffectDescription, 4>& all_causes() {
  static const std::array<EffectDescription, 4> all{
      cause<LineBasis>("line_in_time", {any_force("cosine"), any_force("sine")}, {found("frequency", "Hz")}),
      cause<ChangeBasis>("change_at_a_time",
                         {{"level", "", -1.0f, kUnbounded, 1, Acts::dry_scale}, any_force("offset")},
                         {found("time", "s")}),
      cause<PlaceBasis>(
          "force_at_a_place",
          {any_force("push"), any_force("slope"), {"level", "", -1.0f, kUnbounded, 1, Acts::dry_scale}},
          {found("place", "m"), found("half_width", "m")}),
      cause<CurveBasis>(
          "force_over_time",
          {{"curve", "N", -kUnbounded, kUnbounded, kIntervals + 1, Acts::force, /*smooth=*/true}},
          {found("first", "s"), found("last", "s")})};
  return all;
}
const EffectDescription& line() {
  return all_causes()[0];
}
const EffectDescription& change() {
  return all_causes()[1];
}

const EffectDescription& curve() {
  return all_causes()[3];
}

/// Sums over rows for a regression of a residual on a level and an offset.
struct LevelSums {
  double dd = 0.0, d = 0.0, one = 0.0, rd = 0.0, r = 0.0;

  LevelSums operator-(const LevelSums& other) const {
    return {dd - other.dd, d - other.d, one - other.one, rd - other.rd, r - other.r};
  }
  /// The sum of squares that the regression explains.
  double explained() const {
    if (!(one > 0.0)) return 0.0;
    const double mean = r * r / one;
    const double spread = dd - d * d / one;
    const double joint = rd - r * d / one;
    return spread > 1e-9 * dd ? mean + joint * joint / spread : mean;
  }
};

/// The time that divides the log so that a level and an offset of its own on either side explain most of the
/// residual (a structural break; Chow 1960, Quandt 1960).
std::optional<std::vector<double>> time_of_change(const Measurement& measurement, const FittedModel& model) {
  const Eigen::VectorXd residual_N = model.linearisation->residual_N();
  const Eigen::VectorXd dry_N = at_rows(measurement, model.linearisation->sample_dry_N());
  const Eigen::VectorXd& weights = measurement.fit_weights();
  std::vector<LevelSums> until(static_cast<std::size_t>(residual_N.size()) + 1);
  for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
    const double w = weights(row), d = dry_N(row), r = residual_N(row);
    const LevelSums& before = until[static_cast<std::size_t>(row)];
    until[static_cast<std::size_t>(row) + 1] = {before.dd + w * d * d, before.d + w * d, before.one + w,
                                                before.rd + w * r * d, before.r + w * r};
  }
  double most = 0.0;
  std::size_t best = 0;
  for (std::size_t row = 1; row + 1 < until.size(); ++row) {
    const double explained = until[row].explained() + (until.back() - until[row]).explained();
    if (explained <= most) continue;
    most = explained;
    best = row;
  }
  if (best == 0) return {};
  return std::vector{measurement.sample(measurement.row_samples()[best]).time_s};
}

/// Half widths of a place that are tried, as shares of the travel: from a dent to a tenth of the rail. Wider
/// forces are maps.
constexpr double kHalfWidths[] = {1.0 / 400, 1.0 / 200, 1.0 / 100, 1.0 / 50, 1.0 / 20};
/// Passes that make a place: one alone is an event in time.
constexpr int kFewestPasses = 4;

/// The residual over the position, rows in the order of the position.
class Rail {
 public:
  Rail(const Measurement& measurement, const FittedModel& model)
      : position_m_(at_rows(measurement, measurement.position_m())),
        dry_N_(at_rows(measurement, model.linearisation->sample_dry_N())),
        residual_N_(model.linearisation->residual_N()),
        weights_(measurement.fit_weights()),
        order_(static_cast<std::size_t>(position_m_.size())) {
    std::iota(order_.begin(), order_.end(), Eigen::Index{0});
    std::sort(order_.begin(), order_.end(),
              [this](Eigen::Index a, Eigen::Index b) { return position_m_(a) < position_m_(b); });
  }

  double first_m() const { return position_m_(order_.front()); }
  double travel_m() const { return position_m_(order_.back()) - first_m(); }

  /// The sum of squares that a force within `half_width_m` of `middle_m` explains.
  double explained(double middle_m, double half_width_m) const {
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (auto row = from(middle_m - half_width_m);
         row != order_.end() && position_m_(*row) < middle_m + half_width_m; ++row) {
      auto columns = place_columns((position_m_(*row) - middle_m) / half_width_m);
      columns[2] *= dry_N_(*row);
      const Eigen::Map<const Eigen::Vector3d> column(columns.data());
      gram.noalias() += weights_(*row) * column * column.transpose();
      right.noalias() += weights_(*row) * residual_N_(*row) * column;
    }
    // Scaled to a unit diagonal: forces and the dry friction have other sizes.
    const Eigen::Vector3d scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    gram.diagonal().array() += 1e-9;
    right = scale.cwiseProduct(right);
    return right.dot(gram.ldlt().solve(right));
  }

  /// How often the axis came within `half_width_m` of `middle_m`.
  int passes(double middle_m, double half_width_m) const {
    int count = 0;
    bool within = false;
    for (Eigen::Index row = 0; row < position_m_.size(); ++row) {
      const bool now = std::abs(position_m_(row) - middle_m) < half_width_m;
      if (now && !within) ++count;
      within = now;
    }
    return count;
  }

 private:
  std::vector<Eigen::Index>::const_iterator from(double low_m) const {
    return std::lower_bound(order_.begin(), order_.end(), low_m,
                            [this](Eigen::Index row, double value) { return position_m_(row) < value; });
  }

  Eigen::VectorXd position_m_;
  Eigen::VectorXd dry_N_;
  Eigen::VectorXd residual_N_;
  Eigen::VectorXd weights_;
  std::vector<Eigen::Index> order_;
};

/// The longest slip distance of the model's hysteresis; 0 without one.
double longest_slip_m(const Terms& terms) {
  const Term* hysteresis = find_role(terms, Role::hysteresis);
  if (hysteresis == nullptr) return 0.0;
  double longest = 0.0;
  for (std::size_t i = 0; i < hysteresis->gains.size(); ++i) {
    if (hysteresis->gains[i] > 0.0)
      longest = std::max(longest, hysteresis->shapes[i % hysteresis->gains_per_set()]);
  }
  return longest;
}

std::optional<std::vector<double>> place_and_width(const Measurement& measurement, const FittedModel& model) {
  const Rail rail(measurement, model);
  const double travel_m = rail.travel_m();
  // Within the pre-sliding travel a force over the place is the form of the hysteresis.
  const double least_m = std::max(std::begin(kHalfWidths)[0] * travel_m, longest_slip_m(model.terms));
  const double most_m = std::end(kHalfWidths)[-1] * travel_m;
  if (!(travel_m > 0.0) || least_m >= most_m) return {};
  double most = 0.0;
  std::vector<double> best;
  for (const double share : kHalfWidths) {
    const double half_width_m = share * travel_m;
    if (half_width_m < least_m) continue;
    for (double middle_m = rail.first_m(); middle_m <= rail.first_m() + travel_m;
         middle_m += 0.5 * half_width_m) {
      const double explained = rail.explained(middle_m, half_width_m);
      if (explained <= most) continue;
      most = explained;
      best = {middle_m, half_width_m};
    }
  }
  if (best.empty()) return {};
  const std::vector<ShapeRange> ranges{{0, best[0] - best[1], best[0] + best[1], false, 0.25 * best[1]},
                                       {1, least_m, most_m, true}};
  constexpr int kEvaluations = 60;
  best = refine_shapes(
             ranges, best, [&](const std::vector<double>& at) { return -rail.explained(at[0], at[1]); },
             kEvaluations)
             .shapes;
  if (rail.passes(best[0], best[1]) < kFewestPasses) return {};
  return best;
}

std::string change_text(const Measurement& measurement, const Term& term) {
  return fmt::format("the friction changes at {}: its level by {:+.3g} %, the offset by {}",
                     when_of(measurement, term.shapes[0]), 100.0 * term.gains[0],
                     quantity(term.gains[1], "N"));
}

std::string place_text(const Term& term) {
  return fmt::format(
      "a force sits at one place of the rail, {}, within {} to either side: {}, and the friction is {:+.3g} "
      "% "
      "there",
      quantity(term.shapes[0], "m"), quantity(term.shapes[1], "m"),
      quantity(std::hypot(term.gains[0], term.gains[1]), "N"), 100.0 * term.gains[2]);
}

std::string line_text(const Term& term) {
  double amplitude_N = 0.0;
  for (std::size_t i = 0; i + 1 < term.gains.size(); i += 2)
    amplitude_N = std::max(amplitude_N, std::hypot(term.gains[i], term.gains[i + 1]));
  return fmt::format("the force has a line in time at {}, amplitude {}, whatever the motion",
                     quantity(term.shapes[0], "Hz"), quantity(amplitude_N, "N"));
}

}  // namespace

std::vector<const EffectDescription*> causes_to_try(const Measurement& measurement) {
  std::vector<const EffectDescription*> causes;
  for (const EffectDescription& one : all_causes()) {
    const bool needs_one_clock = &one == &change() || &one == &curve();
    if (!needs_one_clock || measurement.log_count() == 1) causes.push_back(&one);
  }
  return causes;
}

bool is_outside_catalogue(const EffectDescription& effect) {
  return std::any_of(all_causes().begin(), all_causes().end(),
                     [&](const EffectDescription& one) { return &one == &effect; });
}

std::optional<std::vector<double>> shapes_of_cause(const Measurement& measurement, const FittedModel& model,
                                                   const EffectDescription& cause) {
  if (&cause == &change()) return time_of_change(measurement, model);
  if (&cause == &curve())
    return std::vector{measurement.sample(0).time_s,
                       measurement.sample(measurement.sample_count() - 1).time_s};
  if (&cause != &line()) return place_and_width(measurement, model);
  const Eigen::VectorXd weights = measurement.row_weights().cwiseSqrt();
  const Structure strongest =
      line_at_rows(measurement, model.linearisation->residual_N().cwiseProduct(weights));
  if (!(strongest.where > 0.0)) return {};
  return std::vector{strongest.where};
}

FittedModel with_causes_found_again(const Measurement& measurement, FittedModel model) {
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const EffectDescription& cause = *model.terms[i].effect;
    if (!is_outside_catalogue(cause)) continue;
    const FittedModel others = fit_gains(measurement, without(model.terms, cause.text.id), &model);
    const auto shapes = shapes_of_cause(measurement, others, cause);
    if (!shapes || *shapes == model.terms[i].shapes) continue;
    Terms moved = model.terms;
    moved[i].shapes = *shapes;
    FittedModel again = fit_gains(measurement, std::move(moved), &others);
    if (again.train_rmse_N < model.train_rmse_N) model = std::move(again);
  }
  return model;
}

Structure described_cause(const Measurement& measurement, const FittedModel& model, const Term& cause,
                          double without_N) {
  Eigen::VectorXd force_N =
      model.linearisation->columns_of(cause) *
      Eigen::Map<const Eigen::VectorXd>(cause.gains.data(), static_cast<Eigen::Index>(cause.gains.size()));
  const double reduction = 1.0 - model.holdout_rmse_N / std::max(without_N, 1e-300);
  const double where = cause.shapes[0];
  if (cause.effect == &line())
    return {Coordinate::frequency, reduction, where, line_text(cause), std::move(force_N)};
  if (cause.effect == &change())
    return {Coordinate::time, reduction, where, change_text(measurement, cause), std::move(force_N)};
  if (cause.effect == &curve()) {
    const auto [low, high] = std::minmax_element(cause.gains.begin(), cause.gains.end());
    const double step_s = (cause.shapes[1] - cause.shapes[0]) / kIntervals;
    const double low_s = cause.shapes[0] + step_s * static_cast<double>(low - cause.gains.begin());
    const double high_s = cause.shapes[0] + step_s * static_cast<double>(high - cause.gains.begin());
    return {Coordinate::time, reduction, high_s,
            fmt::format("the force depends on time, whatever the motion: lowest at {}, higher by {} at {}",
                        quantity(low_s, "s"), quantity(*high - *low, "N"), quantity(high_s, "s")),
            std::move(force_N)};
  }
  return {Coordinate::position, reduction, where, place_text(cause), std::move(force_N)};
}

}  // namespace slipstack::workbench
