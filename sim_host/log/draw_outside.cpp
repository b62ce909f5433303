// SPDX-License-Identifier: Apache-2.0
// How the effects outside the catalogue are drawn.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

/// A mode above the twentieth of the rate up to which logs are judged at most, far enough that it is no
/// structural resonance there, and below half of Nyquist's frequency. Light, as of a force sensor or a
/// bracket.
Ring draw_ring(const Axis& axis, const MotionProgramme& programme, double rate_Hz, double strength,
               std::uint64_t seed, Rng& rng) {
  Ring ring{1.0, rate_Hz * rng.log_uniform(0.075, 0.2), rng.log_uniform(0.003, 0.04)};
  const double level_N = (strength > 0.0 ? strength : rng.log_uniform(1.0, 4.0)) * noise_floor_N(axis);
  Axis trial = axis;
  trial.force_noise_N = 0.0;
  trial.outside.ring = ring;
  ring.share = std::min(1.0, level_N / simulate_log(trial, programme, rate_Hz, seed).ring_rms_N);
  return ring;
}

/// Second or fourth order, one way or both. The cut is that of a filter for the friction of slow motions:
/// within the band in which a log of this rate is judged, so that what is left of the force is seen to fall.
ForceFilter draw_force_filter(double rate_Hz, Rng& rng) {
  ForceFilter filter;
  filter.cut_Hz = std::min(rng.log_uniform(5.0, 40.0), rate_Hz / 60.0);
  filter.order = rng.pick({2, 4});
  filter.zero_phase = rng.chance(0.5);
  return filter;
}

}  // namespace

std::optional<OutsideKind> outside_by_name(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, OutsideKind>, 7> kNames{
      {{"line", OutsideKind::kLine},
       {"bump", OutsideKind::kBump},
       {"backlash", OutsideKind::kBacklash},
       {"burst", OutsideKind::kBurst},
       {"slip", OutsideKind::kSlip},
       {"ring", OutsideKind::kRing},
       {"force_filter", OutsideKind::kForceFilter}}};
  for (const auto& [name, kind] : kNames) {
    if (name == word) return kind;
  }
  return {};
}

void add_outside(Axis& axis, OutsideKind kind, const MotionProgramme& programme, double rate_Hz,
                 double strength, std::uint64_t seed) {
  Rng rng(seed, "outside");
  const double level_N = (strength > 0.0 ? strength : rng.log_uniform(2.0, 10.0)) * noise_floor_N(axis);
  const double duration_s = programme.duration_s();
  switch (kind) {
    case OutsideKind::kLine: {
      const double frequency_Hz = std::min(rng.pick({50.0, 100.0, rng.uniform(20.0, 120.0)}), 0.4 * rate_Hz);
      axis.outside.line = LineForce{std::sqrt(2.0) * level_N, frequency_Hz, rng.uniform(0.0, kTurn)};
      break;
    }
    case OutsideKind::kBump:
      // It acts only for short times: therefore five times as high as an effect that acts all the time.
      axis.outside.bump = BumpForce{rng.sign() * 5.0 * level_N, axis.stroke_m * rng.uniform(0.25, 0.75),
                                    rng.log_uniform(0.5e-3, 3e-3)};
      break;
    case OutsideKind::kBacklash: {
      Backlash backlash;
      backlash.gap_m = rng.log_uniform(10e-6, 80e-6);
      backlash.motor_share = rng.uniform(0.1, 0.3);
      backlash.contact_rad_per_s = kTurn * std::min(rng.uniform(80.0, 200.0), rate_Hz / 10.0);
      backlash.contact_damping_ratio = rng.uniform(0.2, 0.6);
      axis.outside.backlash = backlash;
      break;
    }
    case OutsideKind::kBurst:
      axis.outside.burst = Burst{duration_s * rng.uniform(0.1, 0.9), rng.log_uniform(0.03, 0.3),
                                 20.0 * level_N + 2.0 * axis.curve.saturation_N()};
      break;
    case OutsideKind::kSlip: {
      EncoderSlip slip;
      const std::size_t count = 1 + rng.below(3);
      while (slip.losses.size() < count) {
        const double t_s = duration_s * rng.uniform(0.05, 0.95);
        // Counts are lost at high speed.
        if (std::fabs(programme.at(t_s).v_mps) < 0.03) continue;
        const double lost_m = axis.curve.travel_m() * rng.log_uniform(2.0, 40.0);
        slip.losses.push_back({t_s, std::round(lost_m / std::max(axis.encoder_resolution_m, 1e-9))});
      }
      axis.outside.slip = slip;
      break;
    }
    case OutsideKind::kRing:
      axis.outside.ring = draw_ring(axis, programme, rate_Hz, strength, seed, rng);
      break;
    case OutsideKind::kForceFilter:
      axis.outside.force_filter = draw_force_filter(rate_Hz, rng);
      break;
  }
}

}  // namespace slipstack::sim
