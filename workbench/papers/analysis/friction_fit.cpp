// SPDX-License-Identifier: Apache-2.0
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "workbench/papers/analysis/friction_models.h"
#include "workbench/papers/analysis/nonnegative_least_squares.h"

namespace slipstack::workbench {
namespace {

Eigen::VectorXd observed(const FrictionData& data, std::span<const double> signal) {
  if (data.observe) return data.observe(signal);
  return Eigen::Map<const Eigen::VectorXd>(signal.data(), static_cast<Eigen::Index>(signal.size()));
}

/// All columns at the rows: model, others, offset.
Eigen::MatrixXd regressors(FrictionKind kind, const std::vector<double>& shape, const FrictionData& data) {
  const Eigen::MatrixXd own = model_columns(kind, shape, slip_distances(kind, data.motion), data.motion);
  const auto others = static_cast<Eigen::Index>(data.others.size());
  Eigen::MatrixXd columns(data.force_N.size(), own.cols() + others + 1);
  for (Eigen::Index c = 0; c < own.cols(); ++c) {
    columns.col(c) = observed(data, {own.col(c).data(), static_cast<std::size_t>(own.rows())});
  }
  for (Eigen::Index c = 0; c < others; ++c) {
    columns.col(own.cols() + c) = observed(data, data.others[static_cast<std::size_t>(c)]);
  }
  columns.col(columns.cols() - 1).setOnes();
  return columns;
}

/// The fit for one choice of shapes.
struct Trial {
  Eigen::VectorXd gains;
  double error = 0.0;
  double held_out = 0.0;
};

Trial try_shape(FrictionKind kind, const std::vector<double>& shape, const FrictionData& data) {
  const Eigen::MatrixXd columns = regressors(kind, shape, data);
  const Eigen::Index rows = data.force_N.size();
  const Eigen::Index fitted = data.fitted_rows > 0 ? std::min(data.fitted_rows, rows) : rows;
  std::vector<bool> free(static_cast<std::size_t>(columns.cols()), false);
  free.back() = true;
  // A table has forces of either sign.
  if (kind == FrictionKind::kVelocityTable) std::fill(free.begin(), free.end() - 1, true);
  // The Stribeck part of a static curve and the spring beside Bouc-Wen may be of either sign.
  if (kind == FrictionKind::kCoulombStribeck || kind == FrictionKind::kBoucWen) free[1] = true;
  Trial trial;
  const NonnegativeFit found =
      nonnegative_least_squares(columns.topRows(fitted), data.force_N.head(fitted), free);
  trial.gains = found.gains;
  trial.error = found.residual_norm / data.force_N.head(fitted).norm();
  if (fitted < rows) {
    const Eigen::VectorXd left =
        data.force_N.tail(rows - fitted) - columns.bottomRows(rows - fitted) * trial.gains;
    trial.held_out = left.norm() / data.force_N.tail(rows - fitted).norm();
  }
  return trial;
}

struct Search {
  FrictionKind kind;
  const FrictionData* data;
};

double objective(unsigned count, const double* logs, double*, void* context) {
  const auto& search = *static_cast<const Search*>(context);
  std::vector<double> shape(count);
  std::transform(logs, logs + count, shape.begin(), [](double log) { return std::exp(log); });
  return try_shape(search.kind, shape, *search.data).error;
}

void run(nlopt_algorithm algorithm, const std::vector<ShapeParameter>& box, Search& search, int evaluations,
         std::vector<double>& logs) {
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> opt(
      nlopt_create(algorithm, static_cast<unsigned>(box.size())), &nlopt_destroy);
  std::vector<double> lower;
  std::vector<double> upper;
  for (const ShapeParameter& parameter : box) {
    lower.push_back(std::log(parameter.lower));
    upper.push_back(std::log(parameter.upper));
  }
  nlopt_set_lower_bounds(opt.get(), lower.data());
  nlopt_set_upper_bounds(opt.get(), upper.data());
  nlopt_set_min_objective(opt.get(), objective, &search);
  nlopt_set_maxeval(opt.get(), evaluations);
  nlopt_set_xtol_rel(opt.get(), 1e-5);
  double error = 0.0;
  // The search ends when its evaluations are used up; the best point is in `logs`.
  nlopt_optimize(opt.get(), logs.data(), &error);
}

}  // namespace

FrictionFit fit_friction(FrictionKind kind, const FrictionData& data, int evaluations) {
  const std::size_t samples = data.motion.position_m.size();
  const bool sizes_match = data.motion.velocity_mps.size() == samples && samples > 1 &&
                           std::all_of(data.others.begin(), data.others.end(),
                                       [&](const auto& column) { return column.size() == samples; }) &&
                           (data.observe || data.force_N.size() == static_cast<Eigen::Index>(samples));
  if (!sizes_match) throw std::invalid_argument("friction models: sizes of motion and force do not match");
  const std::vector<ShapeParameter> box = shapes_of(kind, data.motion);
  std::vector<double> logs;
  logs.reserve(box.size());
  for (const ShapeParameter& parameter : box)
    logs.push_back(0.5 * std::log(parameter.lower * parameter.upper));
  if (!box.empty()) {
    Search search{kind, &data};
    run(NLOPT_GN_DIRECT_L, box, search, evaluations / 2, logs);
    run(NLOPT_LN_SBPLX, box, search, evaluations / 2, logs);
  }
  FrictionFit fit;
  fit.kind = kind;
  fit.slips_m = slip_distances(kind, data.motion);
  for (const double log : logs) fit.shape.push_back(std::exp(log));
  const Trial best = try_shape(kind, fit.shape, data);
  fit.gains = best.gains;
  fit.relative_error = best.error;
  fit.held_out_error = best.held_out;
  return fit;
}

LoopMotion loop_motion(double amplitude_m, double speed_mps, bool inner) {
  constexpr double kBegin = 0.3;
  constexpr double kBack = -0.2;
  constexpr int kPerAmplitude = 400;
  LoopMotion result;
  const double step_m = amplitude_m / kPerAmplitude;
  result.motion.step_s = step_m / speed_mps;
  long at = 0;  // in steps, so that positions are repeated exactly
  const auto push = [&](int direction) {
    result.motion.position_m.push_back(step_m * static_cast<double>(at));
    result.motion.velocity_mps.push_back(direction * speed_mps);
  };
  const auto go = [&](double share) {
    const long target = std::lround(share * kPerAmplitude);
    const int direction = target > at ? 1 : -1;
    while (at != target) {
      at += direction;
      push(direction);
    }
  };
  push(1);
  go(1.0);
  go(-1.0);
  for (int loop = 0; loop < 2; ++loop) {
    for (const double way : {1.0, -1.0}) {
      go(way * kBegin);
      if (inner) {
        go(way * kBack);
        go(way * kBegin);
      }
      result.marks.push_back(result.motion.position_m.size() - 1);
      go(way);
    }
  }
  return result;
}

double return_error(const FrictionFit& fit, double amplitude_m, double speed_mps) {
  const auto force = [&](const LoopMotion& run) {
    const Eigen::MatrixXd columns = model_columns(fit.kind, fit.shape, fit.slips_m, run.motion);
    return Eigen::VectorXd(columns * fit.gains.head(columns.cols()));
  };
  const LoopMotion plain = loop_motion(amplitude_m, speed_mps, false);
  const LoopMotion small = loop_motion(amplitude_m, speed_mps, true);
  const Eigen::VectorXd straight = force(plain);
  const Eigen::VectorXd looped = force(small);
  const double half_height = 0.5 * (straight.maxCoeff() - straight.minCoeff());
  double worst = 0.0;
  for (std::size_t i = 0; i < plain.marks.size(); ++i) {
    const double difference = looped[static_cast<Eigen::Index>(small.marks[i])] -
                              straight[static_cast<Eigen::Index>(plain.marks[i])];
    worst = std::max(worst, std::fabs(difference) / half_height);
  }
  return worst;
}

}  // namespace slipstack::workbench
