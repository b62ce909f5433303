// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/tune.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

using Notches = std::array<DriveNotch, 2>;

/// Judges gains on one measured plant.
class Judge {
 public:
  Judge(const std::vector<ResponsePoint>& plant, const DriveController& present, const TuneRequest& request)
      : plant_(plant), request_(request), feedback_(present, plant), running_(loop(present)) {
    for (const ResponsePoint& point : plant) frequency_Hz_.push_back(point.frequency_Hz);
  }

  std::vector<Complex> loop(const DriveController& gains) const {
    return loop_of(plant_, feedback_.of(gains));
  }
  Margins margins(const DriveController& gains) const { return margins_of(frequency_Hz_, loop(gains)); }

  bool keeps(const DriveController& gains) const {
    const std::vector<Complex> wanted = loop(gains);
    if (std::abs(wanted.back()) > 1.0 - request_.modulus_margin || std::abs(wanted.front()) < 1.0)
      return false;
    for (const Complex& value : wanted) {
      if (std::abs(1.0 + value) < request_.modulus_margin) return false;
    }
    return extra_turns(wanted, running_) == 0;
  }

 private:
  const std::vector<ResponsePoint>& plant_;
  TuneRequest request_;
  FeedbackResponse feedback_;
  std::vector<Complex> running_;
  std::vector<double> frequency_Hz_;
};

DriveController with_bandwidth(const DriveController& present, const Notches& notches, double w,
                               double ratio) {
  DriveController gains = present;
  gains.velocity_gain_N_s_per_m = present.mass_kg * w;
  gains.position_gain_per_s = w / ratio;
  gains.integral_per_s = w / ratio;
  gains.notch = notches;
  return gains;
}

double stiffness(const DriveController& gains) {
  return gains.position_gain_per_s * gains.velocity_gain_N_s_per_m;
}

std::size_t notch_count(const Notches& notches) {
  return static_cast<std::size_t>(std::count_if(
      notches.begin(), notches.end(), [](const DriveNotch& notch) { return notch.frequency_Hz > 0.0; }));
}

// The bandwidth rises for as long as the margin is kept. Beyond there may be gains that keep it again; a loop
// that is worse with less gain is none to be proposed.
std::optional<DriveController> stiffest(const Judge& judge, const TuneRequest& request,
                                        const DriveController& present, const Notches& notches,
                                        double ratio) {
  std::optional<DriveController> found;
  const double now = present.velocity_gain_N_s_per_m / present.mass_kg;
  for (double w = 0.1 * now; w <= request.largest_bandwidth_rad_per_s; w *= 1.03) {
    const DriveController gains = with_bandwidth(present, notches, w, ratio);
    if (judge.keeps(gains)) {
      found = gains;
    } else if (found) {
      break;
    }
  }
  return found;
}

// Off, and at each resonance some widths and depths; two at two resonances with the same width.
std::vector<Notches> notches_to_try(const std::vector<double>& resonances_Hz, double tick_s) {
  std::vector<Notches> all{Notches{}};
  std::vector<double> reachable;
  for (const double frequency_Hz : resonances_Hz) {
    if (frequency_Hz < 0.4 / tick_s && reachable.size() < 3) reachable.push_back(frequency_Hz);
  }
  for (const double damping : {0.1, 0.25, 0.5}) {
    for (const double depth : {0.05, 0.2}) {
      for (std::size_t i = 0; i < reachable.size(); ++i) {
        const DriveNotch one{reachable[i], damping, depth};
        all.push_back({one, DriveNotch{}});
        for (std::size_t k = i + 1; k < reachable.size(); ++k)
          all.push_back({one, DriveNotch{reachable[k], damping, depth}});
      }
    }
  }
  return all;
}

}  // namespace

std::vector<Complex> loop_of(const std::vector<ResponsePoint>& plant, const std::vector<Complex>& feedback) {
  std::vector<Complex> loop;
  for (std::size_t i = 0; i < plant.size(); ++i) loop.push_back(plant[i].plant * feedback[i]);
  return loop;
}

std::vector<double> resonances(const std::vector<ResponsePoint>& plant) {
  std::vector<double> height;
  height.reserve(plant.size());
  for (const ResponsePoint& point : plant)
    height.push_back(std::abs(point.plant) * point.frequency_Hz * point.frequency_Hz);
  struct Peak {
    double frequency_Hz;
    double over;
  };
  std::vector<Peak> peaks;
  for (std::size_t i = 1; i + 1 < plant.size(); ++i) {
    if (height[i] < height[i - 1] || height[i] < height[i + 1]) continue;
    std::vector<double> around;
    for (std::size_t k = 0; k < plant.size(); ++k) {
      const double ratio = plant[k].frequency_Hz / plant[i].frequency_Hz;
      if (ratio > std::numbers::sqrt2 / 2.0 && ratio < std::numbers::sqrt2) around.push_back(height[k]);
    }
    const double usual = median(std::move(around));
    const double relative = plant[i].plant_sd / std::abs(plant[i].plant);
    const double certain = height[i] * (1.0 - 4.0 * relative);
    if (certain > 1.5 * usual) peaks.push_back({plant[i].frequency_Hz, height[i] / usual});
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.over > b.over; });
  std::vector<double> found;
  for (const Peak& peak : peaks) {
    const bool own = std::none_of(found.begin(), found.end(), [&](double other_Hz) {
      return std::fabs(std::log2(other_Hz / peak.frequency_Hz)) < 0.25;
    });
    if (own) found.push_back(peak.frequency_Hz);
  }
  return found;
}

std::optional<Tuning> propose(const std::vector<ResponsePoint>& plant, const DriveController& present,
                              const TuneRequest& request) {
  const Judge judge(plant, present, request);
  std::optional<DriveController> best;
  for (const Notches& notches : notches_to_try(resonances(plant), present.tick_s)) {
    for (const double ratio : {3.0, 3.5, 4.0, 5.0, 6.5, 8.0}) {
      const auto gains = stiffest(judge, request, present, notches, ratio);
      // A notch must earn its place: 5 % more stiffness.
      const bool more = best && notch_count(notches) > notch_count(best->notch);
      if (gains && (!best || stiffness(*gains) > (more ? 1.05 : 1.0) * stiffness(*best))) best = gains;
    }
  }
  if (!best) return std::nullopt;
  return Tuning{*best, judge.margins(*best), notch_count(best->notch)};
}

}  // namespace slipstack::workbench
