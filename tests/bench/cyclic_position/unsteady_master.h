// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>

#include "hal/include/can_port.h"
#include "sim_host/rng.h"

// A master in cyclic synchronous position or velocity whose clock, bus and operating system are not perfect.
namespace slipstack::bench {

enum class Jitter : std::uint8_t { kNone, kUniform, kGaussian, kDesktop };

/// What the bus and the master's computer do to SYNC and to the set-points.
struct Disturbance {
  const char* name = "";
  Jitter jitter = Jitter::kNone;
  double clock_ppm = 0.0;       ///< period of the master against that of the drive
  double lost = 0.0;            ///< probability that a SYNC is lost, and that a set-point is
  std::int64_t late_at = -1;    ///< this SYNC comes 1.5 periods late, the next ones as they can
  std::int64_t held_every = 0;  ///< so many periods apart the bus holds frames back and sends all at once
  double held_periods = 0.0;    ///< for how long
};
inline constexpr Disturbance kPerfect{.name = "perfect"};

/// Sends the set-point and then SYNC, as frames of RPDO 2 (or another) and 080h, at the times that the
/// disturbance makes of n times the period.
class UnsteadyMaster {
 public:
  /// `target`: counts, or counts per second, at a time of the master's, s.
  UnsteadyMaster(CanPort& port, std::uint8_t node, double period_s, const Disturbance& disturbance,
                 std::function<std::int32_t(double)> target)
      : port_(port),
        node_(node),
        period_s_(period_s),
        disturbance_(disturbance),
        target_(std::move(target)),
        rng_(11, disturbance.name) {
    plan();
  }

  /// Sends what is due by now, s since the start. How many periods have begun: sent().
  void run_until(double now_s) {
    while (due_s_ <= now_s) {
      send();
      ++period_;
      plan();
    }
  }
  std::int64_t sent() const { return period_; }
  std::uint8_t controlword = 0x0F;
  std::uint32_t set_point_id = 0x300;  ///< without the node
  bool sends_set_points = true;
  bool sends_sync = true;

 private:
  void plan() {
    const double begin_s = static_cast<double>(period_) * period_s_ * (1.0 + 1e-6 * disturbance_.clock_ppm);
    double late_s = jitter_s();
    if (period_ == disturbance_.late_at) late_s += 1.5 * period_s_;
    double ready_s = begin_s + late_s;
    if (disturbance_.held_every > 0) {
      const std::int64_t first = period_ / disturbance_.held_every * disturbance_.held_every;
      const double free_s = (static_cast<double>(first) + disturbance_.held_periods) * period_s_;
      if (first > 0) ready_s = std::max(ready_s, free_s);
    }
    due_s_ = std::max(due_s_, ready_s);  // a bus keeps the order
  }

  // Half a period back and forth would be the end of any order; a tenth is a bad master. The desktop's:
  // median 51 us, 132 us at 99 %, and once in a thousand up to 2 ms.
  double jitter_s() {
    switch (disturbance_.jitter) {
      case Jitter::kUniform:
        return 0.2 * period_s_ * rng_.uniform();
      case Jitter::kGaussian:
        return std::clamp(0.1 + 0.05 * rng_.normal(), 0.0, 0.5) * period_s_;
      case Jitter::kDesktop: {
        const double body_s = 51e-6 * std::exp(0.409 * rng_.normal());
        return rng_.uniform() < 1e-3 ? std::min(2e-3, 132e-6 / (1e-3 + rng_.uniform())) : body_s;
      }
      default:
        return 0.0;
    }
  }

  void send() {
    const double master_s = static_cast<double>(period_) * period_s_;
    const auto bits = static_cast<std::uint32_t>(target_(master_s));
    CanFrame frame;
    frame.id = set_point_id + node_;
    frame.length = 6;
    frame.data = {controlword, 0};
    for (std::size_t i = 0; i < 4; ++i) frame.data[2 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
    if (sends_set_points && rng_.uniform() >= disturbance_.lost) port_.send(frame);
    CanFrame sync;
    sync.id = 0x080;
    sync.length = 0;
    if (sends_sync && rng_.uniform() >= disturbance_.lost) port_.send(sync);
  }

  CanPort& port_;
  std::uint8_t node_;
  double period_s_;
  Disturbance disturbance_;
  std::function<std::int32_t(double)> target_;
  sim::Rng rng_;
  std::int64_t period_ = 0;
  double due_s_ = 0.0;
};

}  // namespace slipstack::bench
