// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/virgin_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "workbench/papers/analysis/nonnegative_least_squares.h"

namespace slipstack::workbench {
namespace {

double largest_force(const std::vector<VirginSample>& samples) {
  double force = 0.0;
  for (const VirginSample& sample : samples) force = std::max(force, std::fabs(sample.force_N));
  return force;
}

/// Level of the rational curve of length δ nearest to the samples, and the remaining sum of squares.
std::pair<double, double> level_at(const std::vector<VirginSample>& samples, double length_m) {
  const RationalCurve unit{1.0, length_m};
  double yy = 0.0;
  double yf = 0.0;
  double ff = 0.0;
  for (const VirginSample& sample : samples) {
    const double y = unit.force_N(sample.displacement_m);
    yy += y * y;
    yf += y * sample.force_N;
    ff += sample.force_N * sample.force_N;
  }
  return {yf / yy, std::max(0.0, ff - yf * yf / yy)};
}

std::vector<double> geometric(double first, double last, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = first * std::pow(last / first, static_cast<double>(i) / static_cast<double>(count - 1));
  }
  return values;
}

}  // namespace

double PolygonCurve::force_at_N(double displacement) const {
  const auto above = std::lower_bound(displacement_m.begin(), displacement_m.end(), displacement);
  if (above == displacement_m.end()) return force_N.back();
  const auto i = static_cast<std::size_t>(above - displacement_m.begin());
  const double x0 = i == 0 ? 0.0 : displacement_m[i - 1];
  const double y0 = i == 0 ? 0.0 : force_N[i - 1];
  return y0 + (force_N[i] - y0) * (displacement - x0) / (displacement_m[i] - x0);
}

std::vector<VirginSample> virgin_samples(const Loop& loop) {
  const LoopFigures figures = figures_of(loop);
  const auto [low, high] = std::minmax_element(loop.position_m.begin(), loop.position_m.end());
  const auto bottom = static_cast<std::size_t>(low - loop.position_m.begin());
  const auto top = static_cast<std::size_t>(high - loop.position_m.begin());
  const double middle_N = 0.5 * (loop.force_N[bottom] + loop.force_N[top]);
  const std::size_t count = loop.position_m.size();
  std::vector<VirginSample> samples;
  for (std::size_t i = bottom; i != top; i = (i + 1) % count) {
    samples.push_back(
        {0.5 * (loop.position_m[i] - *low), 0.5 * (loop.force_N[i] - middle_N + figures.force_N)});
  }
  for (std::size_t i = top; i != bottom; i = (i + 1) % count) {
    samples.push_back(
        {0.5 * (*high - loop.position_m[i]), 0.5 * (figures.force_N + middle_N - loop.force_N[i])});
  }
  return samples;
}

RationalFit fit_rational(std::span<const Loop> loops) {
  std::vector<VirginSample> samples;
  double amplitude_m = 0.0;
  for (const Loop& loop : loops) {
    const std::vector<VirginSample> more = virgin_samples(loop);
    samples.insert(samples.end(), more.begin(), more.end());
    amplitude_m = std::max(amplitude_m, figures_of(loop).amplitude_m);
  }
  if (samples.empty()) throw std::invalid_argument("no loop to fit a virgin curve to");
  const auto error = [&](double log_length) { return level_at(samples, std::exp(log_length)).second; };
  // A coarse grid first: the error over δ may be flat at its ends, but has one minimum.
  double best = std::log(amplitude_m);
  for (const double length_m : geometric(1e-3 * amplitude_m, 1e3 * amplitude_m, 61)) {
    if (error(std::log(length_m)) < error(best)) best = std::log(length_m);
  }
  double low = best - 0.3;
  double high = best + 0.3;
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 60; ++i) {
    const double a = high - kGolden * (high - low);
    const double b = low + kGolden * (high - low);
    if (error(a) < error(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  const double length_m = std::exp(0.5 * (low + high));
  const auto [level_N, squares] = level_at(samples, length_m);
  const double rms = std::sqrt(squares / static_cast<double>(samples.size()));
  return {{level_N, length_m}, rms / largest_force(samples)};
}

PolygonFit fit_polygon(const Loop& loop, std::size_t elements) {
  const std::vector<VirginSample> samples = virgin_samples(loop);
  const double reach_m = figures_of(loop).amplitude_m;
  const std::vector<double> slip = geometric(1e-3 * reach_m, reach_m, elements);
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(elements));
  Eigen::VectorXd target(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const VirginSample& sample = samples[static_cast<std::size_t>(r)];
    target[r] = sample.force_N;
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      columns(r, c) = std::min(sample.displacement_m, slip[static_cast<std::size_t>(c)]);
    }
  }
  const NonnegativeFit found = nonnegative_least_squares(columns, target);
  PolygonFit fit;
  for (std::size_t i = 0; i < elements; ++i) {
    // An element without stiffness makes no corner of the polygon.
    if (found.gains[static_cast<Eigen::Index>(i)] <= 0.0 && i + 1 < elements) continue;
    double force = 0.0;
    for (std::size_t j = 0; j < elements; ++j) {
      force += found.gains[static_cast<Eigen::Index>(j)] * std::min(slip[i], slip[j]);
    }
    fit.curve.displacement_m.push_back(slip[i]);
    fit.curve.force_N.push_back(force);
  }
  const double rms = found.residual_norm / std::sqrt(static_cast<double>(rows));
  fit.relative_error = rms / largest_force(samples);
  if (fit.relative_error > 0.05) {
    throw std::invalid_argument(
        "the loop is not that of a concave virgin curve: its branches do not bend towards the tips; record a "
        "slow, closed loop without inertia");
  }
  return fit;
}

sim::VirginCurve curve_of_damping(const std::vector<DampingPoint>& points, double force_N) {
  if (points.empty()) throw std::invalid_argument("no damping ratio to fit a virgin curve to");
  double smallest_m = points.front().amplitude_m;
  double largest_m = smallest_m;
  for (const DampingPoint& point : points) {
    // The upper limit is 2/π: that of a slider without a spring.
    if (!(point.amplitude_m > 0.0) ||
        !(point.damping_ratio > 0.0 && point.damping_ratio < 2.0 / std::numbers::pi)) {
      throw std::invalid_argument("amplitudes must be positive, damping ratios between 0 and 2/pi = 0.637");
    }
    smallest_m = std::min(smallest_m, point.amplitude_m);
    largest_m = std::max(largest_m, point.amplitude_m);
  }
  const std::vector<double> lengths = geometric(smallest_m / 30.0, 300.0 * largest_m, 60);
  const auto rows = static_cast<Eigen::Index>(points.size());
  const auto terms = static_cast<Eigen::Index>(lengths.size());
  // The last row fixes the scale; its weight is small, so that it does not change the damping ratios.
  constexpr double kScaleWeight = 1e-4;
  Eigen::MatrixXd columns(rows + 1, terms);
  Eigen::VectorXd target = Eigen::VectorXd::Zero(rows + 1);
  for (Eigen::Index c = 0; c < terms; ++c) {
    const RationalCurve unit{1.0, lengths[static_cast<std::size_t>(c)]};
    const double reach = unit.force_N(largest_m);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const DampingPoint& point = points[static_cast<std::size_t>(r)];
      const double A = point.amplitude_m;
      const double per_ratio = 2.0 * std::numbers::pi * A * unit.force_N(A);
      const double scale = reach * 2.0 * std::numbers::pi * A * point.damping_ratio;
      columns(r, c) = (unit.closed_form(A).area_J - point.damping_ratio * per_ratio) / scale;
    }
    columns(rows, c) = kScaleWeight;
  }
  target[rows] = kScaleWeight;
  const Eigen::VectorXd share = nonnegative_least_squares(columns, target).gains;
  std::vector<sim::CurveTerm> found;
  for (Eigen::Index c = 0; c < terms; ++c) {
    if (!(share[c] > 0.0)) continue;
    const double length_m = lengths[static_cast<std::size_t>(c)];
    const double unit_N = RationalCurve{1.0, length_m}.force_N(largest_m);
    found.push_back({sim::CurveKind::kRational, force_N * share[c] / (share.sum() * unit_N), length_m, 1.0});
  }
  return sim::VirginCurve(std::move(found));
}

}  // namespace slipstack::workbench
