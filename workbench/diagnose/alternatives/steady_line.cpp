// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/steady_line.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

/// The transforms of the intervals of a signal.
class Intervals {
 public:
  Intervals(std::span<const double> signal, const SteadySearch& search)
      : rate_Hz_(search.rate_Hz),
        length_(std::bit_floor(signal.size() / std::max<std::size_t>(search.intervals, 1))) {
    if (length_ < kShortest) return;
    first_ = static_cast<std::size_t>(search.above_Hz / bin_Hz()) + kHalfLobe;
    std::vector<double> windowed(length_);
    for (std::size_t begin = 0; begin + length_ <= signal.size(); begin += length_) {
      for (std::size_t i = 0; i < length_; ++i) {
        const double window = 0.5 - 0.5 * std::cos(2.0 * pi * static_cast<double>(i) / length());
        windowed[i] = window * signal[begin + i];
      }
      std::vector<Complex>& own = transforms_.emplace_back();
      transform_.fwd(own, windowed);
      double energy = 1e-300;
      for (std::size_t k = first_; k < end(); ++k) energy += std::norm(own[k]);
      rms_.push_back(std::sqrt(energy));
    }
  }

  bool suffice() const { return transforms_.size() > 2 && first_ < end(); }
  std::size_t count() const { return transforms_.size(); }
  std::size_t first() const { return first_; }
  std::size_t end() const { return length_ / 2 - kHalfLobe; }
  double length() const { return static_cast<double>(length_); }
  double bin_Hz() const { return rate_Hz_ / length(); }
  /// The part of bin k in interval i; and in units of what the interval holds.
  Complex plain(std::size_t k, std::size_t i) const { return transforms_[i][k]; }
  Complex part(std::size_t k, std::size_t i) const { return transforms_[i][k] / rms_[i]; }

 private:
  static constexpr std::size_t kShortest = 16;  // samples of an interval; shorter ones are mostly lobe
  static constexpr std::size_t kHalfLobe = 2;   // of a Hann window, in bins (Harris 1978)

  double rate_Hz_;
  std::size_t length_;
  std::size_t first_ = 0;
  Eigen::FFT<double> transform_;
  std::vector<std::vector<Complex>> transforms_;
  std::vector<double> rms_;
};

/// How steady one bin is: the phase that its line gains from interval to interval, in turns, within half a
/// turn.
struct Steadiness {
  double turns = 0.0;
  double share = 0.0;   ///< R
  double energy = 0.0;  ///< of what is steady
  double chance(std::size_t count) const {
    return std::pow(1.0 - std::min(share, 1.0), static_cast<double>(count) - 1.0);
  }
};

Steadiness at_phase(const Intervals& intervals, std::size_t k, double turns) {
  Complex sum = 0.0;
  double power = 1e-300;
  for (std::size_t i = 0; i < intervals.count(); ++i) {
    sum += intervals.part(k, i) * std::polar(1.0, -2.0 * pi * turns * static_cast<double>(i));
    power += std::norm(intervals.part(k, i));
  }
  const auto count = static_cast<double>(intervals.count());
  return {turns, std::norm(sum) / (count * power), std::norm(sum) / count};
}

/// The phases that are tried of each bin: at a quarter of the resolution of a transform over the intervals.
std::size_t phases(const Intervals& intervals) {
  return std::bit_ceil(4 * intervals.count());
}

/// The phase of largest R, by that transform.
Steadiness steadiest(const Intervals& intervals, std::size_t k, Eigen::FFT<double>& transform) {
  std::vector<Complex> parts(phases(intervals), 0.0);
  for (std::size_t i = 0; i < intervals.count(); ++i) parts[i] = intervals.part(k, i);
  std::vector<Complex> by_phase;
  transform.fwd(by_phase, parts);
  const auto most = std::max_element(by_phase.begin(), by_phase.end(),
                                     [](Complex a, Complex b) { return std::norm(a) < std::norm(b); });
  const double turns = static_cast<double>(most - by_phase.begin()) / static_cast<double>(by_phase.size());
  return at_phase(intervals, k, turns < 0.5 ? turns : turns - 1.0);
}

/// The phase of largest R between those that were tried, from the nearest one.
Steadiness refined(const Intervals& intervals, std::size_t k, Steadiness nearest) {
  constexpr double kResolved = 1e-3;  // of the distance of the phases that were tried
  const double tried = 1.0 / static_cast<double>(phases(intervals));
  for (double step = 0.5 * tried; step > kResolved * tried; step *= 0.5) {
    for (const double beside : {-step, step}) {
      const Steadiness other = at_phase(intervals, k, nearest.turns + beside);
      if (other.share > nearest.share) nearest = other;
    }
  }
  return nearest;
}

/// The line of bin k with this phase: values and standard errors from the scatter between the intervals.
SteadyLine line_of(const Intervals& intervals, std::size_t k, const Steadiness& steady) {
  const auto count = static_cast<double>(intervals.count());
  std::vector<Complex> turned;
  Complex mean = 0.0;
  for (std::size_t i = 0; i < intervals.count(); ++i) {
    turned.push_back(intervals.plain(k, i) *
                     std::polar(1.0, -2.0 * pi * steady.turns * static_cast<double>(i)));
    mean += turned.back() / count;
  }
  double scatter = 0.0;
  for (const Complex one : turned) scatter += std::norm(one - mean);
  const double error = std::sqrt(0.5 * scatter / (count * (count - 1.0)));  // of each of two components
  // Of a line between two bins a Hann window shows sinc(d) / (1 - d^2) (Harris 1978).
  const double d = steady.turns;
  const double shown = d == 0.0 ? 1.0 : std::sin(pi * d) / (pi * d) / (1.0 - d * d);
  const double newtons = 2.0 / (0.5 * intervals.length() * shown);
  SteadyLine line;
  line.frequency_Hz = (static_cast<double>(k) + steady.turns) * intervals.bin_Hz();
  // The slope of the phases over the intervals, by least squares.
  line.frequency_error_Hz =
      error / std::abs(mean) * std::sqrt(12.0 / (count * count - 1.0)) / (2.0 * pi) * intervals.bin_Hz();
  line.amplitude_N = newtons * std::abs(mean);
  line.amplitude_error_N = newtons * error;
  return line;
}

}  // namespace

std::optional<SteadyLine> steady_line(std::span<const double> signal, const SteadySearch& search) {
  const Intervals intervals(signal, search);
  if (!intervals.suffice()) return {};
  const auto tried = static_cast<double>((intervals.end() - intervals.first()) * phases(intervals));
  Eigen::FFT<double> transform;
  std::vector<Steadiness> bins;
  double steady_energy = 0.0;
  for (std::size_t k = intervals.first(); k < intervals.end(); ++k) {
    bins.push_back(steadiest(intervals, k, transform));
    if (!is_chance(bins.back().chance(intervals.count()), tried)) steady_energy += bins.back().energy;
  }
  const auto best = std::max_element(bins.begin(), bins.end(),
                                     [](const auto& a, const auto& b) { return a.energy < b.energy; });
  if (is_chance(best->chance(intervals.count()), tried)) return {};
  const auto beside = [&](std::ptrdiff_t by) {
    const auto at = best - bins.begin() + by;
    return at < 0 || at >= static_cast<std::ptrdiff_t>(bins.size())
               ? 0.0
               : bins[static_cast<std::size_t>(at)].energy;
  };
  if (best->energy + beside(-1) + beside(1) < kMajority * steady_energy) return {};
  const std::size_t bin = intervals.first() + static_cast<std::size_t>(best - bins.begin());
  SteadyLine line = line_of(intervals, bin, refined(intervals, bin, *best));
  line.chance = best->chance(intervals.count());
  return line;
}

bool is_steady_at(std::span<const double> signal, const SteadySearch& search, double frequency_Hz) {
  const Intervals intervals(signal, search);
  if (!intervals.suffice()) return false;
  const auto k = static_cast<std::size_t>(std::lround(frequency_Hz / intervals.bin_Hz()));
  if (k < intervals.first() || k >= intervals.end()) return false;
  const double turns = frequency_Hz / intervals.bin_Hz() - static_cast<double>(k);
  return !is_chance(at_phase(intervals, k, turns).chance(intervals.count()), 1.0);
}

}  // namespace slipstack::workbench
