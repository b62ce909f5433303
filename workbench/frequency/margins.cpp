// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/margins.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace slipstack::workbench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNoCrossing = std::numeric_limits<double>::quiet_NaN();

// Between two points of the loop, `share` of the way.
struct Between {
  double frequency_Hz;
  Complex value;
};

Between between(double f0, Complex l0, double f1, Complex l1, double share) {
  const double turn = std::arg(l1 / l0);
  const double size = std::exp(std::log(std::abs(l0)) + share * std::log(std::abs(l1) / std::abs(l0)));
  return {f0 * std::pow(f1 / f0, share), std::polar(size, std::arg(l0) + share * turn)};
}

void take_crossover(Margins& margins, const Between& at) {
  const double angle = kPi - std::fabs(std::arg(at.value));
  margins.crossover_Hz = at.frequency_Hz;
  if (!std::isnan(margins.phase_rad) && margins.phase_rad <= angle) return;
  margins.phase_rad = angle;
  margins.phase_Hz = at.frequency_Hz;
}

void take_axis_crossing(Margins& margins, const Between& at) {
  if (at.value.real() >= 0.0) return;
  const double gain = 1.0 / std::abs(at.value);
  if (gain > 1.0) {
    if (!std::isnan(margins.gain) && margins.gain <= gain) return;
    margins.gain = gain;
    margins.gain_Hz = at.frequency_Hz;
  } else {
    margins.gain_down = std::max(margins.gain_down, gain);
  }
}

}  // namespace

Margins margins_of(const std::vector<double>& frequency_Hz, const std::vector<Complex>& loop) {
  Margins margins;
  margins.gain = margins.gain_Hz = margins.phase_rad = margins.phase_Hz = kNoCrossing;
  margins.crossover_Hz = margins.bandwidth_Hz = kNoCrossing;
  margins.modulus = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const double distance = std::abs(1.0 + loop[i]);
    if (distance < margins.modulus) {
      margins.modulus = distance;
      margins.peak_Hz = frequency_Hz[i];
    }
    if (i == 0) continue;
    const Complex before = loop[i - 1];
    const Complex now = loop[i];
    const double log_before = std::log(std::abs(before));
    const double log_now = std::log(std::abs(now));
    if ((log_before > 0.0) != (log_now > 0.0)) {
      const double share = log_before / (log_before - log_now);
      take_crossover(margins, between(frequency_Hz[i - 1], before, frequency_Hz[i], now, share));
    }
    // Angles from the negative axis.
    const double a = std::arg(-before);
    const double b = a + std::arg(now / before);
    if ((a > 0.0) != (b > 0.0) && a != b)
      take_axis_crossing(margins, between(frequency_Hz[i - 1], before, frequency_Hz[i], now, a / (a - b)));
    const double s_before = 1.0 / std::abs(1.0 + before);
    const double s_now = 1.0 / distance;
    const double level = std::sqrt(0.5);
    if (std::isnan(margins.bandwidth_Hz) && s_before < level && s_now >= level) {
      const double share = std::log(level / s_before) / std::log(s_now / s_before);
      margins.bandwidth_Hz = frequency_Hz[i - 1] * std::pow(frequency_Hz[i] / frequency_Hz[i - 1], share);
    }
  }
  margins.peak_sensitivity = 1.0 / margins.modulus;
  margins.delay_s = margins.phase_rad / (2.0 * kPi * margins.phase_Hz);
  return margins;
}

int extra_turns(const std::vector<Complex>& loop, const std::vector<Complex>& stable) {
  double angle = 0.0;
  for (std::size_t i = 1; i < loop.size(); ++i) {
    const Complex before = (1.0 + loop[i - 1]) / (1.0 + stable[i - 1]);
    const Complex now = (1.0 + loop[i]) / (1.0 + stable[i]);
    angle += std::arg(now / before);
  }
  return static_cast<int>(std::lround(angle / kPi));
}

}  // namespace slipstack::workbench
