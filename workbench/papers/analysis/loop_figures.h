// SPDX-License-Identifier: Apache-2.0
// Figures of a hysteresis loop: equivalent stiffness, damping, damping ratio at resonance ([2], section 3.2).
#pragma once

#include <functional>
#include <vector>

namespace slipstack::workbench {

/// One closed loop: points in the order in which they were passed; the last is joined to the first.
struct Loop {
  std::vector<double> position_m;
  std::vector<double> force_N;
};

/// Equivalent quantities at amplitude A, from loop area E and the force Fm at the tips ([2], eqs. 9 to 13):
///   kₑ = Fm/A,   cₑ·ω = E/(π·A²),   ζᵣ = E/(2π·A·Fm).
struct LoopFigures {
  double amplitude_m = 0.0;
  double force_N = 0.0;
  double area_J = 0.0;
  double stiffness_N_per_m = 0.0;              // kₑ, slope of the major axis
  double fundamental_stiffness_N_per_m = 0.0;  // a₁/A, the describing function's, which kₑ approximates
  double damping_N_per_m = 0.0;                // cₑ·ω
  double damping_ratio = 0.0;                  // ζᵣ
};

/// Of a measured or simulated loop. Area by the polygon of its points; amplitude and force from its tips, so
/// neither the centre of the loop nor an offset of the force matters. Throws std::invalid_argument for fewer
/// than eight points, a loop without extent, or one of the wrong sense (it would release energy). A straight
/// line has area zero.
LoopFigures figures_of(const Loop& loop);

/// Of the Masing loop that belongs to a virgin curve y(x): E = 8·∫₀ᴬ y dx − 4·A·y(A), by quadrature to about
/// 1e-9. `virgin_N` is called for 0 ≤ x ≤ A. Throws std::invalid_argument when A or y(A) is not positive.
LoopFigures figures_of_virgin(const std::function<double(double)>& virgin_N, double amplitude_m);

/// y = h₀·(1 − (δ/(x+δ))²), the curve of [2], eq. 14.
struct RationalCurve {
  double level_N = 0.0;   // h₀
  double length_m = 0.0;  // δ

  double force_N(double displacement_m) const;
  double initial_stiffness_N_per_m() const { return 2.0 * level_N / length_m; }
  /// Closed forms: kₑ = (h₀/A)(1 − (δ/(A+δ))²), cₑω = 4h₀A/(π(A+δ)²) ([2], eqs. 15, 16) and
  /// ζᵣ = (2/π)·A/(A+2δ) (eq. 17). The fundamental stiffness has none here: left zero.
  LoopFigures closed_form(double amplitude_m) const;
};

/// ζᵣ of y = xⁿ, 0 < n < 1, the same at every amplitude: (2/π)(1−n)/(1+n) from the definition. The text of
/// [2] prints (1−n)/(1+n), without 2/π.
double power_law_damping_ratio(double exponent);

}  // namespace slipstack::workbench
