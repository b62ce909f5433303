// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/user_effect_starts.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "workbench/base/axis_units.h"
#include "workbench/base/linear_systems.h"

namespace slipstack::workbench {
namespace {

// Chosen so that a bump of a millimetre is found on a metre of rail (docs/user-effect.md).
constexpr std::size_t kMostPoints = 800;   ///< candidates that are evaluated
constexpr std::size_t kMostRows = 12000;   ///< rows at which they are evaluated
constexpr std::size_t kKept = 6;           ///< candidates from which a search starts
constexpr int kBins = 256;                 ///< of the stroke, to find places of strong residual
constexpr std::size_t kStrongPlaces = 24;  ///< such places that become candidates

bool is_place(const EffectDescription& effect, const ShapeRange& range) {
  return linear_unit(effect.shapes[range.index].unit) == "m" && !range.logarithmic;
}

/// Places of the range at which the residual, or the residual times the direction of motion, is strongest:
/// the bins with the largest squared sum per row.
std::vector<double> strong_places(const Measurement& measurement, const ShapeRange& range,
                                  const Eigen::VectorXd& residual_N) {
  struct Bin {
    double even = 0.0, odd = 0.0, rows = 0.0;
    double strength() const { return rows > 0.0 ? std::max(even * even, odd * odd) / rows : 0.0; }
  };
  std::vector<Bin> bins(kBins);
  const double per_m = kBins / std::max(range.upper - range.lower, 1e-12);
  for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    const double place = (measurement.position_m()[sample] - range.lower) * per_m;
    if (place < 0.0 || place >= kBins) continue;
    Bin& bin = bins[static_cast<std::size_t>(place)];
    const double direction = measurement.velocity_mps()[sample] < 0.0 ? -1.0 : 1.0;
    bin.even += residual_N(row);
    bin.odd += residual_N(row) * direction;
    bin.rows += 1.0;
  }
  std::vector<std::size_t> order(kBins);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return bins[a].strength() > bins[b].strength(); });
  std::vector<double> places;
  for (const std::size_t bin : order) {
    if (places.size() == kStrongPlaces || bins[bin].rows == 0.0) break;
    places.push_back(range.lower + (static_cast<double>(bin) + 0.5) / per_m);
  }
  return places;
}

/// Computes how much of the residual's sum of squares an effect explains by itself. The bounds of the gain
/// are respected where there is only one.
class Screen {
 public:
  Screen(const Measurement& measurement, const EffectDescription& effect, const Eigen::VectorXd& residual_N)
      : effect_(effect), basis_(effect.make()) {
    const std::size_t rows = measurement.row_samples().size();
    const std::size_t stride = std::max<std::size_t>(1, (rows + kMostRows - 1) / kMostRows);
    for (std::size_t row = 0; row < rows; row += stride) {
      samples_.push_back(measurement.sample(measurement.row_samples()[row]));
    }
    wanted_.resize(static_cast<Eigen::Index>(samples_.size()));
    weights_.resize(wanted_.size());
    for (Eigen::Index i = 0; i < wanted_.size(); ++i) {
      wanted_(i) = residual_N(i * static_cast<Eigen::Index>(stride));
      weights_(i) = measurement.row_weights()(i * static_cast<Eigen::Index>(stride));
    }
    columns_.resize(effect.gain_count, wanted_.size());
  }

  double explained(const std::vector<double>& shapes) {
    basis_->prepare(shapes, {});
    basis_->run(samples_, columns_.data());
    const Eigen::MatrixXd weighted = columns_ * weights_.asDiagonal();
    Eigen::MatrixXd gram = weighted * columns_.transpose();
    const Eigen::VectorXd right = weighted * wanted_;
    if (gram.rows() == 1) {
      if (gram(0, 0) <= 0.0) return 0.0;
      const GainGroup& group = effect_.gain_groups.front();
      const double gain = std::clamp(right(0) / gram(0, 0), static_cast<double>(group.lower),
                                     static_cast<double>(group.upper));
      return 2.0 * gain * right(0) - gain * gain * gram(0, 0);
    }
    gram.diagonal().array() += 1e-9 * gram.diagonal().maxCoeff() + 1e-300;
    return right.dot(solve_symmetric(gram, right));
  }

 private:
  const EffectDescription& effect_;
  std::unique_ptr<EffectBasis> basis_;
  std::vector<Sample<double>> samples_;
  Eigen::VectorXd wanted_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd columns_;  ///< gains x rows
};

/// All combinations of the starting values of each range, at most kMostPoints.
std::vector<std::vector<double>> points_of(const Measurement& measurement, const EffectDescription& effect,
                                           const std::vector<ShapeRange>& ranges,
                                           const Eigen::VectorXd& residual_N) {
  const auto places = static_cast<double>(std::count_if(
      ranges.begin(), ranges.end(), [&](const auto& range) { return is_place(effect, range); }));
  const double others = static_cast<double>(ranges.size()) - places;
  // A place needs a finer grid than any other shape: 48 values in all beside other shapes, else as many as
  // fit.
  const double of_place = places == 0.0  ? 1.0
                          : others > 0.0 ? std::pow(48.0, 1.0 / places)
                                         : std::pow(kMostPoints, 1.0 / places);
  const auto place_values = static_cast<std::size_t>(std::clamp(of_place, 2.0, 96.0));
  const double left = kMostPoints / std::pow(static_cast<double>(place_values), places);
  const auto values = static_cast<std::size_t>(
      std::clamp(others > 0.0 ? std::pow(std::max(left, 1.0), 1.0 / others) : 1.0, 1.0, 12.0));
  std::vector<std::vector<double>> points{default_shapes(measurement, effect)};
  for (const ShapeRange& range : ranges) {
    std::vector<double> candidates =
        spread(range, is_place(effect, range) ? std::max<std::size_t>(place_values / 2, 1) : values);
    if (is_place(effect, range)) {
      std::vector<double> strong = strong_places(measurement, range, residual_N);
      strong.resize(std::min(strong.size(), place_values - candidates.size()));
      candidates.insert(candidates.end(), strong.begin(), strong.end());
    }
    std::vector<std::vector<double>> product;
    product.reserve(points.size() * candidates.size());
    for (const auto& point : points) {
      for (const double value : candidates) {
        product.push_back(point);
        product.back()[range.index] = value;
      }
    }
    points = std::move(product);
    if (points.size() > kMostPoints) points.resize(kMostPoints);
  }
  return points;
}

}  // namespace

std::vector<std::vector<double>> user_effect_starting_shapes(const Measurement& measurement,
                                                             const EffectDescription& effect,
                                                             const std::vector<ShapeRange>& ranges,
                                                             const Eigen::VectorXd& residual_N) {
  std::vector<std::vector<double>> points = points_of(measurement, effect, ranges, residual_N);
  if (points.size() <= kKept) return points;
  Screen screen(measurement, effect, residual_N);
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) order.emplace_back(-screen.explained(points[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<std::vector<double>> kept;
  for (std::size_t i = 0; i < kKept; ++i) kept.push_back(points[order[i].second]);
  return kept;
}

}  // namespace slipstack::workbench
