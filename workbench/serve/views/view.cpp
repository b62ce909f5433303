// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/analysis/compare_model.h"
#include "workbench/analysis/residual_dynamics.h"
#include "workbench/analysis/worst_intervals.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/report/json_values.h"
#include "workbench/report/parameters.h"
#include "workbench/report/results/comparison_result.h"
#include "workbench/serve/views/loop_damping.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr std::size_t kMostKept = 24;  // force rows and answers of models; 28 bytes for each row of each

std::vector<double> plain(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

/// Not a number where a row is not usable: nothing is drawn there.
Eigen::VectorXd drawn(const Measurement& measurement, const Eigen::VectorXd& rows) {
  Eigen::VectorXd out = rows;
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    if (measurement.row_usable()(i) == 0.0) out(i) = std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

/// The error that cross-validation of these equations gives, N.
double held_out_error(const NormalEquations& equations, const NormalEquations::Constraints& constraints) {
  return equations.cross_validate(constraints, {}).rmse;
}

}  // namespace

std::string View::key_of(int version) {
  return fmt::format("version {}", version);
}

View::View(const LogRequest& request, Progress& progress) : opened_(request, progress) {}

Terms View::on_logs(const Terms& terms) const {
  return terms_on(measurement(), terms);
}

Bytes View::rows() const {
  const Measurement& all = measurement();
  Bytes out;
  json starts = json::array();
  for (const LogPart& part : all.parts()) starts.push_back(part.first_row);
  json logs = json::array();
  double start_s = 0.0;
  for (std::size_t log = 0; log < all.log_count(); ++log) {
    const double duration_s = static_cast<double>(all.log_sample_count(log)) * all.tick_s();
    logs.push_back({{"start_s", start_s}, {"duration_s", duration_s}});
    start_s += duration_s;
  }
  out.header = {{"sample_rate_Hz", all.sample_rate_Hz()},
                {"row_rate_Hz", all.row_rate_Hz()},
                {"bandwidth_Hz", all.bandwidth_Hz()},
                {"excerpt", all.is_excerpt()},
                {"samples", all.whole_sample_count()},
                {"searched_samples", all.sample_count()},
                {"noise_N", all.filtered_force_noise_N()},
                {"starts", starts},
                {"logs", logs}};
  out.add_f8("time_s", plain(row_times(all)));
  out.add_f8("position_m", plain(at_rows(all, all.position_m())));
  out.add_f4("velocity_mps", at_rows(all, all.velocity_mps()));
  out.add_f4("acceleration_mps2", at_rows(all, all.acceleration_mps2()));
  out.add_f4("since_reversal_s", since_reversal_s(all));
  out.add_f4("measured_N", drawn(all, all.force_N()));
  return out;
}

const ForceRows& View::rows_of_model(const std::string& key, const Terms& terms) {
  const auto found = rows_.find(key);
  if (found != rows_.end()) return found->second;
  if (rows_.size() >= kMostKept) rows_.erase(rows_.begin());
  return rows_.emplace(key, force_rows(measurement(), terms)).first->second;
}

Bytes View::answer(const ForceRows& rows, const Terms& terms, bool whole) const {
  const Measurement& all = measurement();
  const Eigen::VectorXd residual_N = rows.residual_N().cwiseProduct(all.row_usable());
  Bytes out;
  out.header["rmse_N"] = number_json(all.weighted_rms(residual_N));
  out.header["relative_error"] = number_json(
      residual_N.norm() / std::max(rows.measured_N.cwiseProduct(all.row_usable()).norm(), 1e-300));
  if (whole) {
    out.header["left"] = dependence_of(all, residual_N);
    out.header["parameters"] = parameters_json(terms);
    out.header["worst"] = worst_json(worst_intervals(all, residual_N));
    out.add_f4("measured_N", drawn(all, rows.measured_N));
    out.add_f4("model_N", drawn(all, rows.model_N));
  }
  out.add_f4("residual_N", drawn(all, rows.residual_N()));
  return out;
}

Bytes View::model(const std::string& key, const Terms& terms) {
  const std::lock_guard lock(lock_);
  const auto known = answers_.find(key);
  if (known != answers_.end()) return known->second;
  if (answers_.size() >= kMostKept) answers_.erase(answers_.begin());
  return answers_.emplace(key, answer(rows_of_model(key, terms), terms, true)).first->second;
}

/// Force of the moving mass at the rows, zero where the model has none.
Eigen::VectorXd View::inertia_N(const Terms& terms) const {
  Terms masses;
  for (const Term& term : terms) {
    if (is_mass(term)) masses.push_back(term);
  }
  if (masses.empty()) return Eigen::VectorXd::Zero(measurement().force_N().size());
  return force_rows(measurement(), masses).model_N;
}

json View::charts(const std::string& key, const Terms& terms, const std::string& other_key,
                  const Terms* other) {
  const std::lock_guard lock(lock_);
  const ForceRows before = rows_of_model(key, terms);
  ForceRows after;
  if (other != nullptr) after = rows_of_model(other_key, *other);
  json data = json::object();
  add_residual_charts(data, measurement(), before, other == nullptr ? nullptr : &after);
  add_residual_dynamics(data, measurement(), before, other == nullptr ? nullptr : &after);
  add_loop_damping(data, measurement(), inertia_N(terms), before, other == nullptr ? nullptr : &after);
  return data;
}

/// The equations of a model at the gains that it has.
const FittedModel& View::fitted(const std::string& key, const Terms& terms) {
  if (fitted_ && fitted_key_ == key) return *fitted_;
  auto next = std::make_unique<FittedModel>();
  next->terms = on_logs(terms);
  next->linearisation = std::make_shared<Linearisation>(measurement(), next->terms);
  next->equations = std::make_shared<NormalEquations>(measurement(), next->linearisation->columns(),
                                                      next->linearisation->target());
  next->train_rmse_N = std::max(measurement().weighted_rms(next->linearisation->residual_N()), 1e-12);
  next->constraints = constraints_of(next->terms, next->train_rmse_N);
  fitted_ = std::move(next);
  fitted_key_ = key;
  return *fitted_;
}

Bytes View::bent(const std::string& key, const Terms& terms, const Terms& by_hand) {
  const std::lock_guard lock(lock_);
  const FittedModel& from = fitted(key, terms);
  const Terms there = on_logs(by_hand);
  const Eigen::VectorXd measured_N = measurement().force_N(measurement_dynamics_of(there));
  return answer({measured_N, from.linearisation->force_at(there)}, there, false);
}

json View::worth(const std::string& key, const Terms& terms) {
  const std::lock_guard lock(lock_);
  const FittedModel& now = fitted(key, terms);
  json list = json::array();
  Eigen::Index next = 0;
  for (const Term& term : now.terms) {
    const auto count = static_cast<Eigen::Index>(term.gains.size());
    json entry{{"effect", term.id()}, {"without_N", nullptr}};
    if (count > 0 && now.terms.size() > 1) {
      NormalEquations::Constraints none = now.constraints;
      none.lower.segment(next, count).setZero();
      none.upper.segment(next, count).setZero();
      entry["without_N"] = number_json(held_out_error(*now.equations, none));
    }
    next += count;
    list.push_back(std::move(entry));
  }
  return {{"with_N", number_json(held_out_error(*now.equations, now.constraints))}, {"effects", list}};
}

json View::with_term(const std::string& key, const Terms& terms, const Term& term) {
  const std::lock_guard lock(lock_);
  const FittedModel& now = fitted(key, terms);
  const Term here = with_gain_sets(measurement(), term);
  const NormalEquations wider = equations_with(measurement(), *now.linearisation, *now.equations, here);
  Terms all = now.terms;
  all.push_back(here);
  const NormalEquations::Constraints constraints = constraints_of(all, now.train_rmse_N);
  return {{"before_N", number_json(held_out_error(*now.equations, now.constraints))},
          {"after_N", number_json(held_out_error(wider, constraints))}};
}

View::Gains View::gains_only(const FittedModel& now, Terms terms) const {
  FittedModel fitted = fit_gains(measurement(), std::move(terms), &now);
  return {std::move(fitted.terms), held_out_error(*now.equations, now.constraints), fitted.holdout_rmse_N};
}

View::Gains View::added(const std::string& key, const Terms& terms, const Term& term) {
  const std::lock_guard lock(lock_);
  const FittedModel& now = fitted(key, terms);
  Terms more = now.terms;
  more.push_back(with_gain_sets(measurement(), term));
  return gains_only(now, std::move(more));
}

View::Gains View::removed(const std::string& key, const Terms& terms, const std::string& effect) {
  const std::lock_guard lock(lock_);
  const FittedModel& now = fitted(key, terms);
  return gains_only(now, without(now.terms, effect));
}

}  // namespace slipstack::workbench
