// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/plausibility.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/estimate/measurement/clocks.h"
#include "workbench/estimate/measurement/motion_terms.h"

namespace slipstack::workbench {
namespace {

/// A statement against the declared input needs this many standard errors by the jackknife over blocks: one
/// false alarm in a million logs (two-sided Gaussian; Student's t of thirty blocks: one in fifty thousand).
constexpr double kCertain = 5.0;

/// A fit with wrong units leaves at least this many times the error of the fit with the right ones: enough to
/// be seen at all. Chosen.
constexpr double kClearlyWorse = 1.1;

/// A magnitude explains an unsigned force that much better than the force itself is explained. On 50 drawn
/// axes (tests/unit/estimate/plausibility_test.cpp with 25 seeds) the error falls to 0.05 to 0.82 where the
/// force had lost its sign, and to no less than 0.996 where a weight kept it positive.
constexpr double kUnsignedBetter = 0.9;

/// Rated speeds of rolling guideways end at 10 m/s, those of air bearings and plain guideways below.
constexpr double kFastestGuideway_mps = 20.0;

constexpr int kTerms = MotionTerms::kCount;
constexpr Eigen::Index kLeastRows = Eigen::Index{4} * kTerms;
using Vector = Eigen::Matrix<double, kTerms, 1>;
using Matrix = Eigen::Matrix<double, kTerms, kTerms>;

struct Sums {
  Matrix normal = Matrix::Zero();
  Vector right = Vector::Zero();
  double force_squares = 0.0;

  Sums& operator+=(const Sums& other) { return add(other, 1.0); }
  Sums& operator-=(const Sums& other) { return add(other, -1.0); }
  Vector solution() const {
    const Vector scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Matrix scaled = scale.asDiagonal() * normal * scale.asDiagonal();
    scaled.diagonal().array() += 1e-9;  // a log may not excite all terms
    return scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(right)));
  }
  double residual_squares(const Vector& x) const {
    return std::max(force_squares - 2.0 * right.dot(x) + x.dot(normal * x), 0.0);
  }

 private:
  Sums& add(const Sums& other, double sign) {
    normal += sign * other.normal;
    right += sign * other.right;
    force_squares += sign * other.force_squares;
    return *this;
  }
};

/// A value with its standard error by the jackknife over blocks.
struct Estimate {
  double value = 0.0;
  double error = 0.0;
  bool is_positive() const { return value > kCertain * error; }
  /// Within 95 %: enough to be no witness of the opposite.
  bool is_likely_positive() const { return value > 2.0 * error; }
  /// How many standard errors it is below zero; 0 above.
  double errors_below_zero() const { return value < 0.0 ? -value / std::max(error, 1e-300) : 0.0; }
};

/// The fit of a force to the motion, and what of it is certain.
class MotionFit {
 public:
  MotionFit(const Measurement& measurement, const MotionTerms& terms, const Eigen::VectorXd& force_N)
      : blocks_(static_cast<std::size_t>(measurement.block_count())) {
    for (Eigen::Index row = 0; row < force_N.size(); ++row) {
      if (measurement.row_usable()(row) == 0.0) continue;
      const Vector at = terms.at_rows.row(row).transpose();
      Sums& sums = blocks_[static_cast<std::size_t>(measurement.row_blocks()[static_cast<std::size_t>(row)])];
      sums.normal += at * at.transpose();
      sums.right += at * force_N(row);
      sums.force_squares += force_N(row) * force_N(row);
    }
    for (const Sums& block : blocks_) all_ += block;
    solution_ = all_.solution();
  }

  const Vector& solution() const { return solution_; }
  double residual_squares() const { return all_.residual_squares(solution_); }
  Estimate inertia() const {
    return jackknife([](const Sums&, const Vector& x) { return x(MotionTerms::kInertia); });
  }
  /// Work of viscous and Coulomb friction over the rows.
  Estimate dissipation() const {
    return jackknife([](const Sums& sums, const Vector& x) {
      return x(MotionTerms::kViscous) * sums.normal(MotionTerms::kViscous, MotionTerms::kViscous) +
             x(MotionTerms::kCoulomb) * sums.normal(MotionTerms::kViscous, MotionTerms::kCoulomb);
    });
  }
  /// Residual with the inertia held at the declared one, and the rest fitted.
  double residual_squares_with_inertia(double inertia) const {
    Sums held = all_;
    Vector only = Vector::Zero();
    only(MotionTerms::kInertia) = inertia;
    held.force_squares = all_.residual_squares(only);
    held.right -= all_.normal * only;
    held.right(MotionTerms::kInertia) = 0.0;
    held.normal.row(MotionTerms::kInertia).setZero();
    held.normal.col(MotionTerms::kInertia).setZero();
    return held.residual_squares(held.solution());
  }

 private:
  template <class Value>
  Estimate jackknife(Value&& value) const {
    Estimate estimate{value(all_, solution_), 0.0};
    const double n = static_cast<double>(blocks_.size());
    double squares = 0.0;
    for (const Sums& block : blocks_) {
      Sums others = all_;
      others -= block;
      const double deviation = value(others, others.solution()) - estimate.value;
      squares += deviation * deviation;
    }
    estimate.error = std::sqrt(squares * (n - 1.0) / n);
    return estimate;
  }

  std::vector<Sums> blocks_;
  Sums all_;
  Vector solution_ = Vector::Zero();
};

/// Inertia and friction are both witnesses, and neither counts where the other contradicts: before it slides
/// an axis is a spring, which in a motion to and fro is an inertia below zero.
bool is_likely_of_right_sign(const MotionFit& fit) {
  return fit.inertia().is_likely_positive() || fit.dissipation().is_likely_positive();
}

/// A force that is a magnitude: its sign is found by turns with the fit, from that of the velocity and from
/// that of the acceleration.
std::optional<InputWarning> unsigned_force(const Measurement& measurement, const MotionTerms& terms,
                                           const MotionFit& as_recorded) {
  const std::vector<double>& force_N = measurement.log().force_N;
  const double lowest_N = *std::min_element(force_N.begin(), force_N.end());
  const double highest_N = *std::max_element(force_N.begin(), force_N.end());
  if (lowest_N < -4.0 * measurement.force_noise_N() || !(highest_N > 0.0)) return {};
  const auto share = [&](double sign) {
    return static_cast<double>(std::count(terms.direction.begin(), terms.direction.end(), sign)) /
           static_cast<double>(terms.direction.size());
  };
  constexpr double kBothWays = 0.1;  // of the time, each way; chosen
  if (std::min(share(1.0), share(-1.0)) < kBothWays) return {};
  for (std::vector<double> signs : {terms.direction, signs_of(measurement.acceleration_mps2())}) {
    constexpr int kTurns = 4;
    for (int turn = 0; turn < kTurns; ++turn) {
      std::vector<double> signed_N(force_N.size());
      for (std::size_t i = 0; i < signed_N.size(); ++i) signed_N[i] = signs[i] * force_N[i];
      const MotionFit fit(measurement, terms, measurement.filtered(signed_N));
      if (fit.residual_squares() < kUnsignedBetter * kUnsignedBetter * as_recorded.residual_squares() &&
          is_likely_of_right_sign(fit)) {
        return InputWarning{
            "force_unsigned",
            fmt::format(
                "the {0} is never negative although the axis moves both ways, and its magnitude "
                "follows from the motion: it seems to be recorded without its sign; record a signed {0}",
                force_word())};
      }
      const Vector& x = fit.solution();
      for (std::size_t i = 0; i < signs.size(); ++i) {
        const double modelled_N = x(MotionTerms::kInertia) * terms.inertia_N[i] +
                                  x(MotionTerms::kViscous) * measurement.velocity_mps()[i] +
                                  x(MotionTerms::kCoulomb) * terms.direction[i];
        signs[i] = modelled_N < 0.0 ? -1.0 : 1.0;
      }
    }
  }
  return {};
}

/// A factor between the inertia in the force and the declared one that a wrong unit makes.
struct UnitFactor {
  double factor;
  double tolerance;  ///< a payload, and a mass fitted to noisy accelerations, change the ratio
  AxisKind kind;
  const char* what;
};
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::array<UnitFactor, 8> kUnitFactors{{
    {1e3, 1.6, AxisKind::linear, "a force in mN that is declared as N"},
    {1e-3, 1.6, AxisKind::linear,
     "a position in mm that is declared as m (or a force in kN as N, or a mass in g as kg)"},
    {1e6, 1.6, AxisKind::linear, "a force in uN that is declared as N"},
    {1e-6, 1.6, AxisKind::linear, "a position in um that is declared as m"},
    {1e3, 1.6, AxisKind::rotary, "a torque in mN m that is declared as N m"},
    {1e-3, 1.6, AxisKind::rotary, "a torque in kN m that is declared as N m"},
    {1.0 / kDegrees, 1.4, AxisKind::rotary, "an angle in degrees that is declared as rad"},
    {2.0 * std::numbers::pi, 1.2, AxisKind::rotary, "an angle in revolutions that is declared as rad"},
}};

std::optional<InputWarning> wrong_units(const Measurement& measurement, const MotionFit& fit) {
  if (!(measurement.log().mass_kg.value_or(0.0) > 0.0)) return {};
  const Estimate ratio = fit.inertia();
  if (!ratio.is_positive()) return {};
  const double declared = fit.residual_squares_with_inertia(1.0);
  if (declared < kClearlyWorse * kClearlyWorse * fit.residual_squares()) return {};
  for (const UnitFactor& one : kUnitFactors) {
    if (one.kind != axis_units().kind) continue;
    const double off = ratio.value / one.factor;
    if (off > one.tolerance || off < 1.0 / one.tolerance) continue;
    return InputWarning{
        "units",
        fmt::format(
            "the inertia in the {0} is {1:.3g} times the declared {2}, as with {3}; check {2} and the units",
            force_word(), ratio.value, axis_key("mass_kg"), one.what)};
  }
  return {};
}

/// Of a carriage on guideways; a shaft may turn as fast as it likes.
std::optional<InputWarning> impossible_speed(const Measurement& measurement) {
  if (axis_is_rotary()) return {};
  std::vector<double> speed_mps(measurement.velocity_mps());
  for (double& speed : speed_mps) speed = std::abs(speed);
  // Not the fastest sample, which may be an outlier.
  const auto nearly_all = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(speed_mps.size()));
  std::nth_element(speed_mps.begin(), speed_mps.begin() + nearly_all, speed_mps.end());
  const double fast_mps = speed_mps[static_cast<std::size_t>(nearly_all)];
  if (fast_mps < kFastestGuideway_mps) return {};
  return InputWarning{"units",
                      fmt::format("the axis moves at {}, faster than any guideway, as with a position in mm "
                                  "that is declared as m; check the units",
                                  quantity(fast_mps, "m/s"))};
}

std::optional<InputWarning> wrong_sign(const MotionFit& fit) {
  if (is_likely_of_right_sign(fit)) return {};
  // Two witnesses, nearly independent: each alone may be less certain where both say the same.
  const double by_friction = fit.dissipation().errors_below_zero();
  const double by_inertia = fit.inertia().errors_below_zero();
  if (std::hypot(by_friction, by_inertia) < kCertain) return {};
  return InputWarning{"force_sign",
                      fmt::format("the {0} {1}: it seems to have the wrong sign; it must be positive towards "
                                  "+position, reverse it or the position",
                                  force_word(),
                                  by_friction > by_inertia ? "gains energy from friction, which only takes it"
                                                           : "accelerates the axis against itself")};
}

std::optional<InputWarning> apart_clocks(const Measurement& measurement, const MotionTerms& terms) {
  const auto apart = clock_difference(measurement, terms);
  if (!apart) return {};
  return InputWarning{
      "clocks",
      fmt::format(
          "the {0} is {1} by {2} against the position: with that shift it follows from the motion far "
          "better, so the two seem to have different clocks; correct the time of one of them",
          force_word(), apart->force_late_s > 0.0 ? "late" : "early",
          quantity_with_interval(std::abs(apart->force_late_s), apart->resolution_s, "s"))};
}

Eigen::VectorXd about_mean(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), std::ssize(values));
  return all - all.mean();
}

/// Whether the values are a multiple of the reference, but for the tenth of their mean square. Chosen.
bool follows(const Eigen::VectorXd& values, const Eigen::VectorXd& reference) {
  constexpr double kShare = 0.9;
  const double product = reference.dot(values);
  const double squares = reference.squaredNorm() * values.squaredNorm();
  return squares > 0.0 && product * product >= kShare * squares;
}

/// A reference that the force follows and the position does not. (Of a spring both do.)
std::optional<InputWarning> interchanged_columns(const Log& log) {
  if (log.reference_position_m.size() != log.position_m.size()) return {};
  const Eigen::VectorXd reference = about_mean(log.reference_position_m);
  if (follows(about_mean(log.position_m), reference) || !follows(about_mean(log.force_N), reference))
    return {};
  return InputWarning{"reference", fmt::format("the {0} follows the reference position and the position does "
                                               "not: the columns of position and {0} seem to be interchanged",
                                               force_word())};
}

/// A reference in another unit than the position, or of the other sign: the axis follows it otherwise.
std::optional<InputWarning> other_reference(const Log& log) {
  if (log.reference_position_m.size() != log.position_m.size()) return {};
  const Eigen::VectorXd reference = about_mean(log.reference_position_m);
  const Eigen::VectorXd position = about_mean(log.position_m);
  if (!follows(position, reference)) return {};
  constexpr double kOtherUnit = 5.0;  // so much must the scales differ; chosen
  const double scale = reference.dot(position) / reference.squaredNorm();
  const bool reversed = scale < 0.0;
  if (!reversed && scale < kOtherUnit && scale > 1.0 / kOtherUnit) return {};
  return InputWarning{"reference",
                      fmt::format("the position follows the reference {}; check the {} of both columns",
                                  reversed ? "with the other sign" : fmt::format("times {:.4g}", scale),
                                  reversed ? "sign" : "units")};
}

}  // namespace

std::vector<InputWarning> input_warnings(const Measurement& measurement) {
  std::vector<InputWarning> warnings;
  if (measurement.row_count() < kLeastRows || measurement.block_count() < 2) return warnings;
  const MotionTerms terms(measurement);
  const MotionFit fit(measurement, terms, measurement.force_N());
  const auto add = [&](std::optional<InputWarning> warning) {
    if (warning) warnings.push_back(std::move(*warning));
    return warning.has_value();
  };
  if (add(interchanged_columns(measurement.log()))) return warnings;
  // A force that is read at another time than the motion may look like one of the wrong sign.
  if (add(apart_clocks(measurement, terms))) return warnings;
  if (!add(unsigned_force(measurement, terms, fit))) add(wrong_sign(fit));
  if (!add(wrong_units(measurement, fit))) add(impossible_speed(measurement));
  add(other_reference(measurement.log()));
  return warnings;
}

}  // namespace slipstack::workbench
