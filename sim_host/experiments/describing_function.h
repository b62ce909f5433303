// SPDX-License-Identifier: Apache-2.0
// The analytic frequency response: hysteresis replaced by the fundamental of its force ([1] section 2, [2]).
#pragma once

#include <complex>
#include <vector>

#include "sim_host/experiments/setup.h"
#include "sim_host/plant/friction/virgin_curve.h"

namespace slipstack::sim {

/// Equivalent stiffness and damping of a Masing loop of amplitude A: F ≈ kₑ·x + cₑ·x′.
struct Equivalent {
  double stiffness_N_per_m = 0.0;        // kₑ, first Fourier coefficient of the loop over A
  double damping_N_per_m = 0.0;          // cₑ·ω = loop area/(π·A²)
  double area_J = 0.0;                   // 8·∫₀ᴬ y dx − 4·A·y(A)
  double tip_stiffness_N_per_m = 0.0;    // y(A)/A, the approximation of kₑ in [2]
  double resonance_damping_ratio = 0.0;  // ζᵣ = area/(2π·A·y(A)) [2]
};
/// Of amplitude A > 0. Fourier integrals over half a period by Gauss-Legendre on panels that shrink towards
/// the reversal, where the curve may be steep; relative error below 1e-9 for the curves of VirginCurve.
Equivalent equivalent(const VirginCurve& curve, double amplitude_m);

/// Stiffness that the linear parts of the axis oppose to a displacement at ω: −m·ω² (arm included, which adds
/// m₂ω⁴/(ω₂² − ω² + 2iζωω₂)·(−1)), Newtonian viscous friction, linear cable chain. N/m.
std::complex<double> dynamic_stiffness(const ExperimentSetup& setup, double rad_per_s);

/// One solution of |kₑ(A) + i·cₑω(A) + D(ω)|·A = F.
struct DescribedPoint {
  double frequency_Hz = 0.0;
  double amplitude_m = 0.0;
  double phase_rad = 0.0;
  std::size_t solutions = 0;  // number of amplitudes that satisfy the equation; the point is the first
};

/// The response at one force and frequency: amplitudes are searched from small to large. `solutions` is 0
/// when there is none (the fundamental of the loop is at most 4/π of the saturation; far below resonance a
/// larger force has no solution within the stroke). Nonlinear effects are neglected.
DescribedPoint describe_response(const ExperimentSetup& setup, double force_N, double frequency_Hz);

}  // namespace slipstack::sim
