// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/stepped_sine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_host/plant/smooth_axis.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/delay_line.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

constexpr double kJumpFactor = 1.5;
constexpr std::size_t kLeastPeriods = 4;

// Decides when a sequence of fundamentals has converged.
class Convergence {
 public:
  explicit Convergence(double tolerance) : tolerance_(tolerance) {}
  bool push(std::complex<double> fundamental) {
    const double change = std::abs(fundamental - last_);
    const double size = std::abs(fundamental);
    ++count_;
    bool small = false;
    if (count_ >= 3) {
      // If the changes shrink by a factor q, the remaining changes sum to q/(1 − q) of the last one.
      const double q = std::min(change / std::max(last_change_, 1e-300), 0.98);
      small = change * std::max(q / (1.0 - q), 0.1) <= tolerance_ * size;
    }
    last_ = fundamental;
    last_change_ = change;
    small_changes_ = small ? small_changes_ + 1 : 0;
    return small_changes_ >= 2 && count_ >= kLeastPeriods;
  }

 private:
  double tolerance_;
  std::complex<double> last_;
  double last_change_ = 0.0;
  std::size_t count_ = 0;
  int small_changes_ = 0;
};

// The position through the sensors of the set-up, one interval of whole periods after another.
class SensedFundamental {
 public:
  SensedFundamental(const SensorSet& sensors, const Rng& noise)
      : sensors_(sensors),
        noise_(noise),
        encoder_(sensors.encoder_resolution_m),
        late_(1.0 / sensors.sample_rate_Hz, sensors.delay_s, sensors.filter_s) {}

  // Least squares of c·cos + s·sin + mean over the samples in (from, to], time since set_force at `zero_s`.
  std::complex<double> over(SmoothAxis& axis, double w, double zero_s, double to_s, double& mean_m) {
    double rows[3][4] = {};
    const double origin_m = axis.position_m();
    while (true) {
      const double next_s = static_cast<double>(sample_ + 1) / sensors_.sample_rate_Hz;
      if (zero_s + next_s > to_s) break;
      ++sample_;
      axis.advance_to(zero_s + next_s);
      const double seen_m = encoder_.position_m(
          axis.position_m() +
          (sensors_.position_noise_m > 0.0 ? sensors_.position_noise_m * noise_.normal() : 0.0));
      const double y = late_.push(seen_m) - origin_m;
      const double basis[3] = {std::cos(w * next_s), std::sin(w * next_s), 1.0};
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) rows[i][k] += basis[i] * basis[k];
        rows[i][3] += basis[i] * y;
      }
    }
    axis.advance_to(to_s);
    for (int i = 0; i < 3; ++i) {
      for (int r = i + 1; r < 3; ++r) {
        const double factor = rows[r][i] / rows[i][i];
        for (int k = i; k < 4; ++k) rows[r][k] -= factor * rows[i][k];
      }
    }
    mean_m = rows[2][3] / rows[2][2];
    const double s = (rows[1][3] - rows[1][2] * mean_m) / rows[1][1];
    const double c = (rows[0][3] - rows[0][1] * s - rows[0][2] * mean_m) / rows[0][0];
    mean_m += origin_m;
    return {c, -s};
  }

 private:
  const SensorSet& sensors_;
  Rng noise_;
  Encoder encoder_;
  DelayLine late_;
  std::size_t sample_ = 0;
};

SinePoint measure(SmoothAxis& axis, const ExperimentSetup& setup, const SteppedSineRequest& request,
                  double force_N, double frequency_Hz, const Rng& noise) {
  const double w = kTurn * frequency_Hz;
  const double zero_s = axis.time_s();
  axis.set_force({0.0, force_N, w, 0.0});
  // Enough samples to determine three numbers in each interval.
  const double per_period = setup.sensors.sample_rate_Hz / frequency_Hz;
  const std::size_t stretch = request.sensors ? static_cast<std::size_t>(std::ceil(20.0 / per_period)) : 1;
  SensedFundamental sensed(setup.sensors, noise);
  Convergence settling(request.settled);
  SinePoint point;
  point.frequency_Hz = frequency_Hz;
  std::complex<double> fundamental;
  for (std::size_t periods = 0; periods < request.most_periods && !point.settled; periods += stretch) {
    const double to_s = zero_s + static_cast<double>(periods + stretch) / frequency_Hz;
    if (request.sensors) {
      fundamental = sensed.over(axis, w, zero_s, to_s, point.mean_m);
    } else {
      axis.clear_integrals();
      axis.advance_to(to_s);
      fundamental = 2.0 * frequency_Hz * axis.integral();
      point.mean_m = axis.integral_origin_m() + frequency_Hz * axis.mean_integral();
    }
    point.periods = static_cast<double>(periods + stretch);
    point.settled = settling.push(fundamental);
  }
  point.amplitude_m = std::abs(fundamental);
  point.phase_rad = std::arg(fundamental);
  // A displacement lags its force: phases lie in (−3π/2, π/2].
  if (point.phase_rad > 0.5 * std::numbers::pi) point.phase_rad -= kTurn;
  return point;
}

// Whether there is a jump between two points: see run_stepped_sine(). `chain` holds the state of the axis at
// the first.
bool jumps_between(const ExperimentSetup& setup, const SteppedSineRequest& request, const SweepChain& chain,
                   const SinePoint& from, const SinePoint& to) {
  const double whole = std::fabs(std::log(to.amplitude_m / from.amplitude_m));
  if (!(whole > std::log(kJumpFactor))) return false;
  SteppedSineRequest bare = request;
  bare.sensors = false;
  // Where the motion is not periodic, more periods would not make it so.
  bare.most_periods = std::min<std::size_t>(request.most_periods, 40);
  SmoothAxis axis(setup.axis, setup.position_m, {request.tolerance, 0.0});
  axis.restore(chain.state);
  constexpr int kParts = 8;
  double last_m = from.amplitude_m;
  double largest = 0.0;
  for (int i = 1; i <= kParts; ++i) {
    const double frequency_Hz =
        from.frequency_Hz * std::pow(to.frequency_Hz / from.frequency_Hz, static_cast<double>(i) / kParts);
    const double amplitude_m = measure(axis, setup, bare, chain.force_N, frequency_Hz, Rng(0)).amplitude_m;
    largest = std::max(largest, std::fabs(std::log(amplitude_m / last_m)));
    last_m = amplitude_m;
  }
  return largest > std::log(kJumpFactor) && largest > 0.5 * whole;
}

std::size_t directions_of(const SteppedSineRequest& request) {
  return (request.up ? 1U : 0U) + (request.down ? 1U : 0U);
}

// How far a static force moves the axis from rest.
double static_displacement_m(const ExperimentSetup& setup, double force_N) {
  const double share = force_N / setup.axis.curve.saturation_N();
  return share >= 1.0 ? HUGE_VAL : setup.axis.curve.displacement_m(share);
}

}  // namespace

void check_stepped_sine(const ExperimentSetup& setup, const SteppedSineRequest& request) {
  const double limit_N = setup.axis.current_limit_A * setup.axis.motor_constant_N_per_A;
  if (request.forces_N.empty()) throw SetupError(fmt::format("{}: no force level; give some", setup.name));
  for (const double force_N : request.forces_N) {
    if (!(std::isfinite(force_N) && force_N > 0.0)) {
      throw SetupError(fmt::format("a force of {:g} N cannot move the axis; give a positive one", force_N));
    }
    if (force_N > limit_N) {
      throw SetupError(
          fmt::format("the drive of {} gives at most {:g} N, not {:g}; lower the force or raise "
                      "current_limit_A",
                      setup.name, limit_N, force_N));
    }
    const double count_m = setup.sensors.encoder_resolution_m;
    if (request.sensors && static_displacement_m(setup, force_N) < 0.5 * count_m) {
      throw SetupError(
          fmt::format("a force of {:g} N cannot move the axis by half an encoder step of {:g} m; give more "
                      "force, or leave "
                      "--sensors out",
                      force_N, count_m));
    }
  }
  if (request.frequencies_Hz.empty())
    throw SetupError(fmt::format("{}: no frequency; give some", setup.name));
  const double nyquist_Hz = 0.5 * setup.sensors.sample_rate_Hz;
  double last_Hz = 0.0;
  for (const double frequency_Hz : request.frequencies_Hz) {
    if (!(std::isfinite(frequency_Hz) && frequency_Hz > 0.0)) {
      throw SetupError(fmt::format("a frequency of {:g} Hz is no sine; give a positive one", frequency_Hz));
    }
    if (frequency_Hz >= nyquist_Hz) {
      throw SetupError(fmt::format(
          "{:g} Hz is not below half the sampling rate of {} ({:g} Hz); lower it or raise sample_rate_Hz",
          frequency_Hz, setup.name, nyquist_Hz));
    }
    if (frequency_Hz <= last_Hz) throw SetupError("frequencies must rise; sort them and name each once");
    last_Hz = frequency_Hz;
  }
}

std::size_t points_per_level(const SteppedSineRequest& request) {
  return directions_of(request) * request.repeats * request.frequencies_Hz.size();
}

void prepare_sweeps(const ExperimentSetup& setup, const SteppedSineRequest& request,
                    std::vector<SweepChain>& chains) {
  check_stepped_sine(setup, request);
  chains.resize(request.forces_N.size());
  for (std::size_t i = 0; i < chains.size(); ++i) chains[i].force_N = request.forces_N[i];
}

void run_sweep_chain(const ExperimentSetup& setup, const SteppedSineRequest& request, std::size_t index,
                     SweepChain& chain, const SweepControl& control) {
  if (chain.complete) return;
  SmoothAxis::Options options;
  options.tolerance = request.tolerance;
  SmoothAxis axis(setup.axis, setup.position_m, options);
  if (!chain.state.empty()) axis.restore(chain.state);
  const std::size_t directions = directions_of(request);
  for (std::size_t i = 0; i < directions * request.repeats; ++i) {
    const bool up = request.up && (i % directions == 0);
    if (chain.sweeps.size() <= i) chain.sweeps.push_back({chain.force_N, up, i / directions, {}});
    Sweep& sweep = chain.sweeps[i];
    for (std::size_t k = sweep.points.size(); k < request.frequencies_Hz.size(); ++k) {
      if (control.stop != nullptr && control.stop->load(std::memory_order_relaxed)) return;
      const std::size_t at = up ? k : request.frequencies_Hz.size() - 1 - k;
      const Rng noise(request.seed, fmt::format("position noise {} {} {}", index, i, k));
      SinePoint point = measure(axis, setup, request, chain.force_N, request.frequencies_Hz[at], noise);
      if (k > 0) point.jump = jumps_between(setup, request, chain, sweep.points.back(), point);
      sweep.points.push_back(point);
      chain.state = axis.snapshot();
      if (control.point_done) control.point_done();
    }
  }
  chain.complete = true;
}

void run_stepped_sine(const ExperimentSetup& setup, const SteppedSineRequest& request,
                      std::vector<SweepChain>& chains, const SweepControl& control) {
  prepare_sweeps(setup, request, chains);
  for (std::size_t i = 0; i < chains.size(); ++i) run_sweep_chain(setup, request, i, chains[i], control);
}

std::vector<double> log_frequencies(double low_Hz, double high_Hz, std::size_t count) {
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    out[i] = i + 1 == count && count > 1 ? high_Hz : low_Hz * std::pow(high_Hz / low_Hz, share);
  }
  return out;
}

Peak peak_of(const Sweep& sweep) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < sweep.points.size(); ++i) {
    if (sweep.points[i].amplitude_m > sweep.points[best].amplitude_m) best = i;
  }
  Peak peak{sweep.points[best].frequency_Hz, sweep.points[best].amplitude_m, false};
  if (best == 0 || best + 1 == sweep.points.size()) return peak;
  peak.inside = true;
  const auto x = [&](std::size_t i) { return std::log(sweep.points[i].frequency_Hz); };
  const auto y = [&](std::size_t i) { return std::log(sweep.points[i].amplitude_m); };
  // Newton's form of the parabola through three points.
  const double d1 = (y(best) - y(best - 1)) / (x(best) - x(best - 1));
  const double d2 = (y(best + 1) - y(best)) / (x(best + 1) - x(best));
  const double bend = (d2 - d1) / (x(best + 1) - x(best - 1));
  if (bend == 0.0) return peak;
  const double top = 0.5 * (x(best - 1) + x(best)) - 0.5 * d1 / bend;
  peak.frequency_Hz = std::exp(top);
  peak.amplitude_m =
      std::exp(y(best - 1) + d1 * (top - x(best - 1)) + bend * (top - x(best - 1)) * (top - x(best)));
  return peak;
}

}  // namespace slipstack::sim
