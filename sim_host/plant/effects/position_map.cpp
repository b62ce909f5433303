// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/effects/position_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace slipstack::sim {
namespace {

// Second derivatives of the natural cubic spline with unit spacing (Thomas algorithm).
std::vector<double> spline_curvatures(const std::vector<double>& y) {
  const std::size_t n = y.size();
  std::vector<double> curvature(n, 0.0);
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 4.0 - upper[i - 1];
    upper[i] = 1.0 / pivot;
    curvature[i] = (6.0 * (y[i + 1] - 2.0 * y[i] + y[i - 1]) - curvature[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvature[i] -= upper[i] * curvature[i + 1];
  return curvature;
}

}  // namespace

std::string_view name(MapKind kind) {
  switch (kind) {
    case MapKind::kSpline:
      return "cubic_spline";
    case MapKind::kSines:
      return "sum_of_sines";
    case MapKind::kPiecewiseLinear:
      return "piecewise_linear";
    case MapKind::kBump:
      return "bump";
    case MapKind::kTrend:
      return "linear_trend";
  }
  return "unknown";
}

PositionMap PositionMap::spline(double stroke_m, std::vector<double> knot_values) {
  PositionMap map;
  map.kind_ = MapKind::kSpline;
  map.stroke_m_ = stroke_m;
  map.curvatures_ = spline_curvatures(knot_values);
  map.knots_ = std::move(knot_values);
  map.normalise();
  return map;
}

PositionMap PositionMap::piecewise_linear(double stroke_m, std::vector<double> knot_values) {
  PositionMap map;
  map.kind_ = MapKind::kPiecewiseLinear;
  map.stroke_m_ = stroke_m;
  map.curvatures_.assign(knot_values.size(), 0.0);
  map.knots_ = std::move(knot_values);
  map.normalise();
  return map;
}

PositionMap PositionMap::sines(double stroke_m, std::vector<Sine> sines) {
  PositionMap map;
  map.kind_ = MapKind::kSines;
  map.stroke_m_ = stroke_m;
  map.sines_ = std::move(sines);
  map.normalise();
  return map;
}

PositionMap PositionMap::bump(double stroke_m, double centre_m, double width_m) {
  PositionMap map;
  map.kind_ = MapKind::kBump;
  map.stroke_m_ = stroke_m;
  map.centre_m_ = centre_m;
  map.width_m_ = width_m;
  map.normalise();
  return map;
}

PositionMap PositionMap::trend(double stroke_m) {
  PositionMap map;
  map.kind_ = MapKind::kTrend;
  map.stroke_m_ = stroke_m;
  map.normalise();
  return map;
}

double PositionMap::raw(double x_m) const {
  switch (kind_) {
    case MapKind::kSpline:
    case MapKind::kPiecewiseLinear: {
      const double last = static_cast<double>(knots_.size() - 1);
      const double u = std::clamp(x_m / stroke_m_, 0.0, 1.0) * last;
      const std::size_t i = std::min(static_cast<std::size_t>(u), knots_.size() - 2);
      const double b = u - static_cast<double>(i);
      const double a = 1.0 - b;
      return a * knots_[i] + b * knots_[i + 1] +
             ((a * a * a - a) * curvatures_[i] + (b * b * b - b) * curvatures_[i + 1]) / 6.0;
    }
    case MapKind::kSines: {
      double sum = 0.0;
      for (const Sine& sine : sines_) {
        sum += sine.amplitude * std::sin(2.0 * std::numbers::pi * x_m / sine.length_m + sine.phase_rad);
      }
      return sum;
    }
    case MapKind::kBump: {
      const double c = 1.0 / std::cosh((x_m - centre_m_) / width_m_);
      return c * c;
    }
    case MapKind::kTrend:
      return x_m / stroke_m_;
  }
  return 0.0;
}

double PositionMap::value(double x_m) const {
  return scale_ * (raw(std::clamp(x_m, 0.0, stroke_m_)) - mean_);
}

void PositionMap::normalise() {
  constexpr int kPoints = 2000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double y = raw(stroke_m_ * (i + 0.5) / kPoints);
    sum += y;
    squares += y * y;
  }
  mean_ = sum / kPoints;
  scale_ = 1.0 / std::sqrt(squares / kPoints - mean_ * mean_);
  for (int i = 0; i <= kPoints; ++i) peak_ = std::max(peak_, std::fabs(value(stroke_m_ * i / kPoints)));
}

std::vector<double> PositionMap::numbers() const {
  switch (kind_) {
    case MapKind::kSpline:
    case MapKind::kPiecewiseLinear:
      return knots_;
    case MapKind::kSines: {
      std::vector<double> all;
      for (const Sine& sine : sines_) all.insert(all.end(), {sine.amplitude, sine.length_m, sine.phase_rad});
      return all;
    }
    case MapKind::kBump:
      return {centre_m_, width_m_};
    case MapKind::kTrend:
      return {};
  }
  return {};
}

double Ripple::value(double x_m) const {
  double sum = 0.0;
  for (const Harmonic& harmonic : harmonics) {
    sum += harmonic.amplitude *
           std::sin(2.0 * std::numbers::pi * harmonic.order * x_m / pitch_m + harmonic.phase_rad);
  }
  return sum;
}

}  // namespace slipstack::sim
