// SPDX-License-Identifier: Apache-2.0
// Quantities that change along the rail: preload maps, and ripple with the magnets.
#pragma once

#include <string_view>
#include <vector>

namespace slipstack::sim {

enum class MapKind { kSpline, kSines, kPiecewiseLinear, kBump, kTrend };
std::string_view name(MapKind kind);

/// A map over the stroke with mean 0 and root mean square 1 (both over the stroke, numerically):
///   spline            natural cubic spline through knots
///   sines             Σ aᵢ·sin(2πx/Lᵢ + φᵢ)
///   piecewise_linear  through knots
///   bump              sech²((x − c)/w)
///   trend             x
/// Outside the stroke the value at its end holds.
class PositionMap {
 public:
  PositionMap() = default;
  static PositionMap spline(double stroke_m, std::vector<double> knot_values);
  static PositionMap piecewise_linear(double stroke_m, std::vector<double> knot_values);
  struct Sine {
    double amplitude;
    double length_m;
    double phase_rad;
  };
  static PositionMap sines(double stroke_m, std::vector<Sine> sines);
  static PositionMap bump(double stroke_m, double centre_m, double width_m);
  static PositionMap trend(double stroke_m);

  double value(double x_m) const;
  MapKind kind() const { return kind_; }
  /// Largest magnitude over the stroke.
  double peak() const { return peak_; }
  /// The numbers behind the map (knots, or triples of sines, or centre and width), for the record.
  std::vector<double> numbers() const;

 private:
  void normalise();
  double raw(double x_m) const;

  MapKind kind_ = MapKind::kTrend;
  double stroke_m_ = 1.0;
  std::vector<double> knots_;
  std::vector<double> curvatures_;
  std::vector<Sine> sines_;
  double centre_m_ = 0.0;
  double width_m_ = 1.0;
  double mean_ = 0.0;
  double scale_ = 1.0;
  double peak_ = 0.0;
};

/// Σ amplitudeₕ·sin(2πh·x/pitch + phaseₕ), up to three harmonics.
struct Ripple {
  double pitch_m = 0.024;
  struct Harmonic {
    int order;
    double amplitude;
    double phase_rad;
  };
  std::vector<Harmonic> harmonics;

  double value(double x_m) const;
};

}  // namespace slipstack::sim
