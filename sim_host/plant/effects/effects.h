// SPDX-License-Identifier: Apache-2.0
// Everything that can act on the axis beside inertia and pre-sliding hysteresis, each with its own numbers.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "sim_host/plant/effects/position_map.h"
#include "sim_host/plant/effects/velocity_weakening.h"

namespace slipstack::sim {

/// c·v·(|v|/0.1 m/s)^(exponent−1): exponent 1 is Newton's, below 1 is grease that thins under shear.
struct Viscous {
  double coefficient_N_s_per_m = 0.0;
  double exponent = 1.0;
  double force_N(double velocity_mps) const;
};

/// c₂·v·|v|^(exponent−1); exponent 2 is the drag of air.
struct QuadraticDrag {
  double coefficient = 0.0;
  double exponent = 2.0;
  double force_N(double velocity_mps) const;
};

/// A seal: one more Maxwell element that slips after `slip_m`, far below what an encoder resolves.
struct Coulomb {
  double level_N = 0.0;
  double slip_m = 20e-9;
};

struct PositionPreload {
  PositionMap map;
  double depth = 0.0;
  double factor(double x_m) const { return 1.0 + depth * map.value(x_m); }
};

enum class AccelerationLaw { kProportional, kSmooth, kSaturating };
std::string_view name(AccelerationLaw law);

/// Hysteresis level × (1 + gain·h(a)), in s²/m:  proportional h = |a|;  smooth h = √(a² + a₀²) − a₀;
/// saturating h = |a|/(1 + |a|/a₀).
struct AccelerationPreload {
  AccelerationLaw law = AccelerationLaw::kProportional;
  double gain_s2_per_m = 0.0;
  double knee_mps2 = 1.0;
  double shape(double acceleration_mps2) const;
  double factor(double acceleration_mps2) const { return 1.0 + gain_s2_per_m * shape(acceleration_mps2); }
};

enum class AsymmetryLaw { kByForce, kByVelocity };
std::string_view name(AsymmetryLaw law);

/// Levels that differ each way. On the hysteresis, × (1 + level·σ) with σ = tanh of its own force over a
/// twentieth of its saturation (by_force: continuous through a reversal) or of v/0.5 mm/s (by_velocity);
/// viscous: adds `viscous_N_s_per_m`·|v|.
struct DirectionAsymmetry {
  AsymmetryLaw law = AsymmetryLaw::kByForce;
  double level = 0.0;
  double viscous_N_s_per_m = 0.0;
  double factor(double hysteresis_N, double saturation_N, double velocity_mps) const;
};

/// k·u·(1 + stiffening·(u/stroke)²), u = x − rest.
struct CableChain {
  double stiffness_N_per_m = 0.0;
  double rest_m = 0.0;
  double stiffening = 0.0;
  double stroke_m = 1.0;
  double force_N(double x_m) const;
};

/// An arm on a spring: `ratio` of the moving mass, a part of the mass that the log states; its own
/// frequency and damping when the carriage is held.
struct Resonance {
  double ratio = 0.0;
  double frequency_rad_per_s = 100.0;
  double damping_ratio = 0.02;
};

/// The recorded force lags the motion: a pure delay, then a first-order filter.
struct RecordingDelay {
  double delay_s = 0.0;
  double filter_s = 0.0;
};

enum class DriftKind { kWarming, kLinear, kRunIn, kCreep };
std::string_view name(DriftKind kind);
enum class DriftTarget { kHysteresis, kViscous, kBoth };
std::string_view name(DriftTarget target);

/// Level × (1 + depth·d(t)), τ its time:  warming d = 1 − exp(−t/τ);  linear d = t/τ;
/// run_in d = 1/(1 + t/τ) − 1;  creep d = ln(1 + t/τ).
struct Drift {
  DriftKind kind = DriftKind::kWarming;
  DriftTarget target = DriftTarget::kHysteresis;
  double depth = 0.0;
  double time_s = 30.0;
  double factor(double t_s) const;
};

/// The effects that act; an empty optional: the effect does not exist.
struct Effects {
  std::optional<Coulomb> coulomb;
  std::optional<Viscous> viscous;
  std::optional<QuadraticDrag> drag;
  std::optional<WeakeningCurve> stribeck;
  std::optional<FrictionalLag> lag;
  std::optional<PositionPreload> preload;
  std::optional<AccelerationPreload> acceleration;
  std::optional<DirectionAsymmetry> asymmetry;
  std::optional<Ripple> ripple;        // N
  std::optional<Ripple> motor_ripple;  // relative
  std::optional<double> offset_N;
  std::optional<CableChain> cable;
  std::optional<double> payload_kg;
  std::optional<Resonance> resonance;
  std::optional<RecordingDelay> delay;
  std::optional<Drift> drift;
};

/// A force at a frequency fixed in time: mains pick-up, a fan.
struct LineForce {
  double amplitude_N = 0.0;
  double frequency_Hz = 50.0;
  double phase_rad = 0.0;
};

/// A conservative hump in the force at one place: F = amplitude·exp(−((x − centre)/width)²/2).
struct BumpForce {
  double amplitude_N = 0.0;
  double centre_m = 0.0;
  double width_m = 1e-3;
};

/// Motor and encoder on one side of a gap, the guided carriage on the other; contact by a spring that pushes
/// but does not pull. `motor_share` of the mass is on the motor's side.
struct Backlash {
  double gap_m = 20e-6;
  double motor_share = 0.2;
  double contact_rad_per_s = 1000.0;  // of the carriage on the contact spring
  double contact_damping_ratio = 0.3;
};

/// An interval of the record in which the force channel has outliers.
struct Burst {
  double start_s = 0.0;
  double duration_s = 0.05;
  double amplitude_N = 0.0;
};

/// An encoder that loses counts: from each time on, that many counts are missing.
struct EncoderSlip {
  struct Loss {
    double time_s;
    double counts;
  };
  std::vector<Loss> losses;
};

/// A lightly damped mode in the path of the measured force (sensors/ringing_mode.h). `share` of the force
/// passes it; the axis does not feel it.
struct Ring {
  double share = 0.0;
  double frequency_Hz = 300.0;
  double damping_ratio = 0.01;
};

/// The publisher's low pass of the recorded force alone (sensors/low_pass.h); the position is as recorded.
struct ForceFilter {
  double cut_Hz = 20.0;
  int order = 4;
  bool zero_phase = true;
  /// Where half of the amplitude is left: the cut itself where the filter runs both ways.
  double half_Hz() const;
};

/// Effects outside the catalogue.
struct Outside {
  std::optional<LineForce> line;
  std::optional<BumpForce> bump;
  std::optional<Backlash> backlash;
  std::optional<Burst> burst;
  std::optional<EncoderSlip> slip;
  std::optional<Ring> ring;
  std::optional<ForceFilter> force_filter;
};

}  // namespace slipstack::sim
