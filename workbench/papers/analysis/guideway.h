// SPDX-License-Identifier: Apache-2.0
// The design calculator of [2]: from one measured loop to the loop of another guideway.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/papers/analysis/virgin_fit.h"

namespace slipstack::workbench {

enum class BallMaterial { kSteel, kSiliconNitride, kDiamondCoated };

std::string_view name(BallMaterial material);
/// "steel", "silicon_nitride", "diamond_coated"; empty for other words.
std::optional<BallMaterial> ball_material(std::string_view word);

/// The parameters that [2] varies: balls between two V-grooves.
struct BallContact {
  double load_per_ball_N = 54.0;
  double groove_angle_deg = 90.0;  // full angle α
  double ball_diameter_m = 6e-3;
  double balls = 2.0;
  BallMaterial material = BallMaterial::kSteel;
};

/// Throws std::invalid_argument when a load, diameter or number is not positive or the angle not in
/// (0°, 180°].
void check(const BallContact& contact);

/// Factors from one guideway to another: F′ = force·F at x′ = displacement·x.
struct Scaling {
  double force = 1.0;
  double displacement = 1.0;

  double stiffness() const { return force / displacement; }
};

/// The law of [2], eq. 19, for one ball, F·sin²(α/2)/√W = ψ(x/(√R·sin²(α/2))), times the number of balls in
/// parallel. The material is not part of it: material_scale(). R enters as a ratio, so diameter serves for
/// radius.
Scaling scaling(const BallContact& from, const BallContact& to);

/// Steel has a ζᵣ about 22 % lower than the other two at the same amplitude, and the longest pre-rolling
/// travel ([2], 4.4.1).
inline constexpr double kSteelDampingShare = 0.78;

/// The displacement factor of a change of material: the scale of the curve whose ζᵣ has, on average over the
/// amplitudes of the loop (in logarithm), the ratio that [2] measured. 1 when nothing changes. Throws
/// std::invalid_argument when there is none: the loop does not determine ζᵣ at other amplitudes.
double material_scale(const PolygonCurve& curve, BallMaterial from, BallMaterial to);

struct GuidewayPrediction {
  Scaling scaling;                         // all factors together
  PolygonCurve curve;                      // the virgin curve of the new guideway
  Loop loop;                               // the measured loop, scaled
  LoopFigures figures;                     // of that loop
  double initial_stiffness_N_per_m = 0.0;  // k₀
};

/// From a measured loop and its virgin curve (fit_polygon) to another guideway. `force_ratio`: level of the
/// new material over that of the old, where it is known; the text of [2] gives its sign only (steel highest),
/// so 1 leaves the level unchanged.
GuidewayPrediction predict(const Loop& measured, const PolygonCurve& curve, const BallContact& from,
                           const BallContact& to, double force_ratio = 1.0);

/// Masing loop of a virgin curve at an amplitude, 2·`half` points.
Loop masing_loop(const PolygonCurve& curve, double amplitude_m, std::size_t half = 200);

/// Distance of loops from each other, as a share of the force: root mean square over loops and displacements
/// of virgin samples up to the smallest reach, around their mean, over the mean's largest force. It measures
/// whether scaled loops coincide.
double loop_spread(const std::vector<Loop>& loops);

/// A loop with both axes multiplied.
Loop scaled(const Loop& loop, const Scaling& factors);

}  // namespace slipstack::workbench
