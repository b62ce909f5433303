// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/observer/cases.h"

#include <numbers>
#include <stdexcept>

#include "tests/bench/documented_table.h"

namespace slipstack::observer {
namespace {

constexpr std::array<std::uint64_t, 2> kSeeds{1, 2};
constexpr double kPause_s = 0.3;

ObservedAxis axis_of(std::uint64_t seed, double level_error,
                     const std::function<void(AxisParameters&)>& drive) {
  Setting setting;
  setting.seed = seed;
  setting.level_error = level_error;
  setting.drive = drive;
  return ObservedAxis(setting);
}

void push(ObservedAxis& axis, double force_N, Visits& visits) {
  axis.loop().pushed_N = force_N;
  axis.watch(0.2, [&](double) { visits.pushed.add(axis.error_m() * 1e6); });
  axis.loop().pushed_N = 0.0;
  axis.watch(0.3, [&](double since_s) {
    if (since_s > 0.25) visits.left.add(axis.error_m() * 1e6);
  });
  axis.move(1e-3, [](double) {});
  axis.watch(kPause_s, [](double) {});
}

}  // namespace

void Drive::set(AxisParameters& parameters) const {
  parameters.compensate = compensate;
  parameters.observe_friction = observe;
  parameters.disturbance_share = disturbance_share;
}

std::vector<Drive> drives() {
  return {{"mass alone", false, false, 0.0F},
          {"model on the reference alone", true, false, 0.0F},
          {"with the friction observer", true, true, 0.0F},
          {"mass, 2000h:08 = 1", false, false, 1.0F},
          {"reference alone, 2000h:08 = 1", true, false, 1.0F},
          {"friction observer, 2000h:08 = 1", true, true, 1.0F}};
}

Visits visit(const Drive& drive, double level_error) {
  // By power of ten of the way: changes of size on the way, too.
  constexpr std::array<int, 21> kSizes{0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0, 0, 1, 2, 0};
  constexpr std::array<double, 3> kWays_m{1e-2, 1e-3, 1e-4};
  Visits visits;
  for (const std::uint64_t seed : kSeeds) {
    ObservedAxis axis = axis_of(seed, level_error, [&](AxisParameters& p) { drive.set(p); });
    double sign = 1.0;
    for (const int size : kSizes) {
      const auto place = static_cast<std::size_t>(size);
      axis.move(sign * kWays_m[place], [&](double) { visits.moving[place].add(axis.error_m() * 1e6); });
      axis.watch(kPause_s, [&](double) { visits.standing[place].add(axis.error_m() * 1e6); });
      sign = -sign;
    }
    for (const double force_N : {5.0, -10.0, 20.0}) push(axis, force_N, visits);
    axis.expect_enabled();
  }
  return visits;
}

Spread moves_with_pause(const Drive& drive, double level_error, double pause_s) {
  constexpr int kMoves = 40;
  Spread error_um;
  for (const std::uint64_t seed : kSeeds) {
    ObservedAxis axis = axis_of(seed, level_error, [&](AxisParameters& p) { drive.set(p); });
    for (int move = 0; move < kMoves; ++move) {
      axis.move(move % 2 == 0 ? 1e-3 : -1e-3, [&](double since_s) {
        if (move >= kMoves / 2 && since_s < 0.05) error_um.add(axis.error_m() * 1e6);
      });
      axis.watch(pause_s, [](double) {});
    }
    axis.expect_enabled();
  }
  return error_um;
}

Led lead(float share, double level_error) {
  constexpr double kWay_m = 0.02, kRate_rad_per_s = std::numbers::pi;
  constexpr double kStiffness_N_per_m = 2000.0, kDamping_N_s_per_m = 600.0;  // of the hand
  Led led;
  for (const std::uint64_t seed : kSeeds) {
    ObservedAxis axis =
        axis_of(seed, level_error, [share](AxisParameters& p) { p.torque_friction_share = share; });
    axis.controller().command_all(0x0FU | kTorqueMode);
    const double begin_m = axis.loop().plant.position_m();
    axis.watch(4.0, [&](double time_s) {
      const double phase = kRate_rad_per_s * time_s;
      const double ahead_m = begin_m + kWay_m * std::sin(phase) - axis.loop().plant.position_m();
      const double faster_mps = kWay_m * kRate_rad_per_s * std::cos(phase) - axis.loop().plant.velocity_mps();
      axis.loop().pushed_N = kStiffness_N_per_m * ahead_m + kDamping_N_s_per_m * faster_mps;
      if (time_s > 1.0) led.hand_N.add(axis.loop().pushed_N);
    });
    axis.loop().pushed_N = 0.0;
    axis.watch(1.0, [](double) {});
    led.coast_mps = std::max(led.coast_mps, std::fabs(axis.loop().plant.velocity_mps()));
    axis.expect_enabled();
  }
  return led;
}

std::string table() {
  std::string text;
  const auto print = printer_to(text);
  constexpr std::array<double, 3> kErrors{0.03, 0.2, -0.3};
  print("%-33s %27s   %27s   %7s %7s\n", "error, um rms; model's friction", "moves of 10, 1, 0.1 mm",
        "in the 0.3 s behind them", "push", "0.25 s");
  print("%-33s %9s%9s%9s   %9s%9s%9s   %7s %7s\n", "", "10", "1", "0.1", "10", "1", "0.1", "peak", "after");
  for (const double level_error : kErrors) {
    print("%+.0f %%\n", 100.0 * level_error);
    for (const Drive& drive : drives()) {
      const Visits v = visit(drive, level_error);
      print("  %-31s %9.1f%9.1f%9.1f   %9.1f%9.1f%9.1f   %7.0f %7.1f\n", drive.name, v.moving[0].rms(),
            v.moving[1].rms(), v.moving[2].rms(), v.standing[0].rms(), v.standing[1].rms(),
            v.standing[2].rms(), v.pushed.peak, v.left.rms());
    }
  }
  constexpr std::array<double, 4> kPauses_s{0.0, 0.01, 0.1, 0.3};
  print("\n%-33s %9s%9s%9s%9s\n", "moves of 1 mm, pause between, ms", "0", "10", "100", "300");
  for (const double level_error : kErrors) {
    for (const Drive& drive : {drives()[1], drives()[2]}) {
      print("%+4.0f %% %-27s ", 100.0 * level_error, drive.observe ? "with the observer" : "reference alone");
      for (const double pause_s : kPauses_s)
        print("%9.1f", moves_with_pause(drive, level_error, pause_s).rms());
      text += "\n";
    }
  }
  print("\n%-33s %27s   %27s\n", "hand-guided, target 0", "hand, N rms", "1 s after letting go, mm/s");
  print("%-33s %9s%9s%9s   %9s%9s%9s\n", "share of the friction, 2000h:25", "-30 %", "+3 %", "+45 %", "-30 %",
        "+3 %", "+45 %");
  for (const float share : {0.0F, 0.5F, 0.8F, 1.0F}) {
    std::array<Led, 3> led{lead(share, -0.3), lead(share, 0.03), lead(share, 0.45)};
    print("  %-31.1f ", static_cast<double>(share));
    for (const Led& one : led) print("%9.1f", one.hand_N.rms());
    text += "  ";
    for (const Led& one : led) print("%9.1f", 1e3 * one.coast_mps);
    text += "\n";
  }
  return text;
}

}  // namespace slipstack::observer
