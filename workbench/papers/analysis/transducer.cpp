// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/transducer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "workbench/papers/analysis/nonnegative_least_squares.h"

namespace slipstack::workbench {
namespace {

/// One stop operator: elongation of an element after the load has changed.
double stopped(double elongation_N, double change_N, double slip_N) {
  return std::clamp(elongation_N + change_N, -slip_N, slip_N);
}

/// +1 when the way up reads above the way down, −1 when below.
double sense_of(const Reversibility& found) {
  double sum = 0.0;
  for (const double value : found.hysteresis) sum += value;
  return sum < 0.0 ? -1.0 : 1.0;
}

}  // namespace

TransducerModel::TransducerModel(double sensitivity, std::vector<double> stiffness,
                                 std::vector<double> slip_N, std::vector<double> table_N,
                                 std::vector<double> table_mV_per_V)
    : sensitivity_(sensitivity),
      stiffness_(std::move(stiffness)),
      slip_N_(std::move(slip_N)),
      table_N_(std::move(table_N)),
      table_(std::move(table_mV_per_V)) {
  if (stiffness_.size() != slip_N_.size() || table_N_.size() != table_.size()) {
    throw std::invalid_argument("transducer: sizes differ");
  }
  reset();
}

void TransducerModel::reset() {
  load_N_ = 0.0;
  elongation_N_.assign(slip_N_.size(), 0.0);
}

double TransducerModel::linearity(double load_N) const {
  if (table_N_.empty() || load_N < table_N_.front() || load_N > table_N_.back()) return 0.0;
  const auto above = std::lower_bound(table_N_.begin(), table_N_.end(), load_N);
  const auto i = static_cast<std::size_t>(above - table_N_.begin());
  if (i == 0) return table_.front();
  const double share = (load_N - table_N_[i - 1]) / (table_N_[i] - table_N_[i - 1]);
  return table_[i - 1] + share * (table_[i] - table_[i - 1]);
}

double TransducerModel::hysteresis_at(double load_N) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < slip_N_.size(); ++i) {
    sum += stiffness_[i] * stopped(elongation_N_[i], load_N - load_N_, slip_N_[i]);
  }
  return sum;
}

void TransducerModel::move_to(double load_N) {
  for (std::size_t i = 0; i < slip_N_.size(); ++i) {
    elongation_N_[i] = stopped(elongation_N_[i], load_N - load_N_, slip_N_[i]);
  }
  load_N_ = load_N;
}

double TransducerModel::load_of(double signal, double full_scale_N) const {
  double low = -0.05 * full_scale_N;
  double high = 1.05 * full_scale_N;
  while (high - low > 1e-9 * full_scale_N) {
    const double middle = 0.5 * (low + high);
    (reading_at(middle) < signal ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

TransducerModel extract_by_formula(const StepRecord& record, const StepRecord* linearity) {
  const Reversibility found = reversibility(record);
  const double sense = sense_of(found);
  const std::vector<double>& x = found.load_N;
  std::vector<double> y = found.hysteresis;
  if (linearity != nullptr) {
    const Reversibility other = reversibility(*linearity);
    const TransducerModel line(0.0, {}, {}, other.load_N, other.linearity);
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = found.rise[i] - line.linearity(x[i]);
  }
  std::vector<double> slope;
  for (std::size_t i = 1; i < x.size(); ++i) slope.push_back((y[i] - y[i - 1]) / (x[i] - x[i - 1]));
  // Rotating the curve adds the same to every slope and does not change their differences; dh/dF = 0 at full
  // scale means that no element needs to slip there.
  std::vector<double> stiffness;
  std::vector<double> slip_N;
  double with = 0.0;
  double against = 0.0;
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const double change = slope[i - 1] - slope[i];
    (sense * change > 0.0 ? with : against) += std::fabs(change);
    if (sense * change <= 0.0) continue;
    stiffness.push_back(change);
    slip_N.push_back(record.preloads > 0 ? 0.5 * x[i] : x[i]);
  }
  if (against > with / 3.0) {
    throw std::invalid_argument(
        "the hysteresis of the first rise is not concave: noise or creep hides it; wait longer at each step");
  }
  return with_line_of(TransducerModel(found.sensitivity, stiffness, slip_N, {}, {}), record);
}

TransducerModel with_line_of(const TransducerModel& model, const StepRecord& record) {
  const Reversibility found = reversibility(record);
  // The elements alone, evaluated like the readings: the difference is the line of the transducer.
  TransducerModel elements(found.sensitivity, model.stiffness(), model.slip_N(), {}, {});
  StepRecord mine = record;
  for (sim::LoadStep& step : mine.steps) {
    step.signal_mV_per_V = elements.reading_at(step.load_N);
    elements.move_to(step.load_N);
  }
  const Reversibility its = reversibility(mine);
  std::vector<double> table;
  for (std::size_t j = 0; j < found.load_N.size(); ++j) {
    table.push_back(found.linearity[j] - its.linearity[j]);
  }
  // The elements have a slope of their own between zero and full scale; the line has the remainder.
  return TransducerModel(2.0 * found.sensitivity - its.sensitivity, model.stiffness(), model.slip_N(),
                         found.load_N, table);
}

TransducerModel extract_by_least_squares(const StepRecord& record) {
  const Reversibility found = reversibility(record);
  const double sense = sense_of(found);
  constexpr std::size_t kElements = 40;
  constexpr Eigen::Index kOthers = 5;
  const double full_N = record.full_scale_N;
  const auto rows = static_cast<Eigen::Index>(record.steps.size());
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(kElements) + kOthers);
  Eigen::VectorXd target(rows);
  std::vector<double> slip_N(kElements);
  for (std::size_t i = 0; i < kElements; ++i) {
    slip_N[i] = 0.02 * full_N * std::pow(50.0, static_cast<double>(i) / (kElements - 1));
  }
  std::vector<double> elongation(kElements, 0.0);
  double before_N = 0.0;
  bool known = false;
  const double start_s = record.steps.front().time_s;
  const double length_s = record.steps.back().time_s - start_s;
  for (Eigen::Index r = 0; r < rows; ++r) {
    const sim::LoadStep& step = record.steps[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < kElements; ++i) {
      elongation[i] = stopped(elongation[i], step.load_N - before_N, slip_N[i]);
      columns(r, static_cast<Eigen::Index>(i)) = sense * elongation[i] / full_N;
    }
    before_N = step.load_N;
    const double u = step.load_N / full_N;
    columns.row(r).tail<kOthers>() << u, u * (1.0 - u), u * (1.0 - u) * (1.0 - 2.0 * u), 1.0,
        (step.time_s - start_s) / length_s;
    target[r] = step.signal_mV_per_V;
    // Before the first preload the state of the elements is unknown.
    known = known || record.preloads == 0 || step.load_N >= 0.999 * full_N;
    if (!known) {
      columns.row(r).setZero();
      target[r] = 0.0;
    }
  }
  std::vector<bool> free(kElements + kOthers, false);
  std::fill(free.begin() + kElements, free.end(), true);
  const Eigen::VectorXd gains = nonnegative_least_squares(columns, target, free).gains;
  const Eigen::VectorXd others = gains.tail<kOthers>();
  std::vector<double> stiffness;
  std::vector<double> used_N;
  for (std::size_t i = 0; i < kElements; ++i) {
    if (!(gains[static_cast<Eigen::Index>(i)] > 0.0)) continue;
    stiffness.push_back(sense * gains[static_cast<Eigen::Index>(i)] / full_N);
    used_N.push_back(slip_N[i]);
  }
  std::vector<double> table_N;
  std::vector<double> table;
  constexpr int kTable = 200;
  for (int i = 0; i <= kTable; ++i) {
    const double u = static_cast<double>(i) / kTable;
    table_N.push_back(u * full_N);
    table.push_back(u * (1.0 - u) * (others[1] + others[2] * (1.0 - 2.0 * u)));
  }
  return TransducerModel(others[0] / full_N, stiffness, used_N, table_N, table);
}

TransducerErrors errors_of(TransducerModel model, const StepRecord& record) {
  const std::vector<sim::LoadStep>& steps = record.steps;
  for (std::size_t i = 0; i <= record.cycle; ++i) model.move_to(steps[i].load_N);
  const TransducerModel start = model;
  // Offset and drift: readings at zero load before and after, less the reading of the model.
  const auto missing = [&](const sim::LoadStep& step, const TransducerModel& at) {
    return step.signal_mV_per_V - at.reading_at(step.load_N);
  };
  for (std::size_t i = record.cycle; i < steps.size(); ++i) model.move_to(steps[i].load_N);
  const double offset = missing(steps[record.cycle], start);
  const double drift = missing(steps.back(), model) - offset;
  const double start_s = steps[record.cycle].time_s;
  const double length_s = steps.back().time_s - start_s;
  TransducerErrors errors;
  TransducerModel known = start;
  TransducerModel blind = start;
  double squares = 0.0;
  for (std::size_t i = record.cycle; i < steps.size(); ++i) {
    const double signal = steps[i].signal_mV_per_V - offset - drift * (steps[i].time_s - start_s) / length_s;
    known.move_to(steps[i].load_N);
    errors.residual_mV_per_V.push_back(signal - known.reading_at(steps[i].load_N));
    const double load_N = blind.load_of(signal, record.full_scale_N);
    blind.move_to(load_N);
    errors.load_error_N.push_back(load_N - steps[i].load_N);
    errors.largest_mV_per_V = std::max(errors.largest_mV_per_V, std::fabs(errors.residual_mV_per_V.back()));
    errors.largest_load_N = std::max(errors.largest_load_N, std::fabs(errors.load_error_N.back()));
    squares += errors.load_error_N.back() * errors.load_error_N.back();
  }
  errors.rms_load_N = std::sqrt(squares / static_cast<double>(errors.load_error_N.size()));
  errors.uncertainty_N = errors.largest_load_N / std::sqrt(3.0);
  return errors;
}

TransducerModel line_and_linearity(const StepRecord& record) {
  const Reversibility found = reversibility(record);
  return TransducerModel(found.sensitivity, {}, {}, found.load_N, found.linearity);
}

}  // namespace slipstack::workbench
