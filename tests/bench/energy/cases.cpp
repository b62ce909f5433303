// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/energy/cases.h"

#include "tests/bench/documented_table.h"

namespace slipstack::energy {
namespace {

constexpr double kFree_J = 71.0;  // nothing brakes: 70 J, less friction, plus what a push has added

Failure encoder(std::function<void(EncoderReading&)> change) {
  Failure failure;
  failure.encoder = std::move(change);
  return failure;
}

Failure frozen() {
  auto first = std::make_shared<std::int32_t>(0);
  auto known = std::make_shared<bool>(false);
  return encoder([=](EncoderReading& reading) {
    if (!*known) *first = reading.counts;
    *known = true;
    reading.counts = *first;
  });
}

Failure reversed() {
  auto first = std::make_shared<std::int32_t>(0);
  auto known = std::make_shared<bool>(false);
  return encoder([=](EncoderReading& reading) {
    if (!*known) *first = reading.counts;
    *known = true;
    reading.counts = 2 * *first - reading.counts;
  });
}

Failure measured(float current_A, bool valid, double for_s) {
  Failure failure;
  failure.measurement = [=](host::HostMotorCurrent& motor, double since_s) {
    motor.measurement_follows = since_s > for_s;
    if (motor.measurement_follows) {
      motor.measurement = {motor.set_point_A, true};
    } else {
      motor.measurement = {current_A, valid};
    }
  };
  return failure;
}

Failure with(void (*change)(Failure&)) {
  Failure failure;
  change(failure);
  return failure;
}

// Before the fault the axis is brought to speed by the master; afterwards what is left of the master goes on.
class Master402 {
 public:
  Master402(Machine& machine, const Case& one) : machine_(machine), case_(one) {}

  void begin() {
    can::Bench& bench = machine_.bench();
    switch (case_.mode) {
      case Drive402::kProfilePosition: {
        bench.enable(1);
        const double target_m = case_.has_limit ? kLimit_m : 5.0;
        bench.write(0x607A, 0, static_cast<std::uint32_t>(machine_.counts(target_m)), 4);
        bench.write(0x6040, 0, 0x1F, 2);
        return;
      }
      case Drive402::kProfileVelocity:
        bench.enable(3);
        bench.write(0x60FF, 0, 2000000, 4);
        return;
      case Drive402::kCyclicVelocity:
        map_velocity();
        bench.write(0x60C2, 1, 2, 1);
        bench.nmt(0x01);
        return bench.enable(9);
      case Drive402::kCyclicPosition:
        bench.write(0x60C2, 1, 2, 1);
        bench.nmt(0x01);
        return bench.enable(8);
      case Drive402::kCyclicTorque:
        return bench.enable(10);
    }
  }

  // Every tick; a frame every 2 ms.
  void step(std::int64_t tick, bool failed) {
    can::Bench& bench = machine_.bench();
    if (tick % 20 != 0 || (failed && case_.master_silent)) return;
    if (case_.mode == Drive402::kCyclicPosition || case_.mode == Drive402::kCyclicVelocity) {
      speed_mps_ = std::min(kSpeed_mps, speed_mps_ + 10.0 * 0.002);
      wanted_m_ += speed_mps_ * 0.002;
      const bool velocity = case_.mode == Drive402::kCyclicVelocity;
      const auto target = static_cast<std::uint32_t>(velocity ? std::lround(speed_mps_ * 1e6)
                                                              : machine_.counts(wanted_m_ + case_.ahead_m));
      if (!(failed && case_.sync_lost)) {
        bench.send(velocity ? 0x505 : 0x305,
                   {0x0F, 0x00, static_cast<std::uint8_t>(target), static_cast<std::uint8_t>(target >> 8),
                    static_cast<std::uint8_t>(target >> 16), static_cast<std::uint8_t>(target >> 24)});
        bench.send(0x080, {});
      }
    } else if (case_.mode == Drive402::kCyclicTorque) {
      const double force = machine_.velocity_mps() < kSpeed_mps - 0.05 || failed ? case_.force : 0.0;
      bench.write(0x6071, 0, static_cast<std::uint32_t>(static_cast<std::int32_t>(force)), 2);
    }
    bench.all();
  }

 private:
  // RPDO 4: controlword and target velocity, with SYNC.
  void map_velocity() {
    can::Bench& bench = machine_.bench();
    bench.write(0x1403, 1, 0x80000500U + can::kNode, 4);
    bench.write(0x1403, 2, 1, 1);
    bench.write(0x1603, 1, 0x60400010, 4);
    bench.write(0x1603, 2, 0x60FF0020, 4);
    bench.write(0x1603, 0, 2, 1);
    bench.write(0x1403, 1, 0x500U + can::kNode, 4);
  }

  Machine& machine_;
  const Case& case_;
  double wanted_m_ = 0.0;
  double speed_mps_ = 0.0;
};

}  // namespace

std::vector<Case> cases() {
  using enum Drive402;
  std::vector<Case> all;
  const Failure none;
  const auto add = [&](Case one, double most_J, double most_without_J) {
    one.most_J = most_J;
    one.most_without_J = most_without_J;
    all.push_back(std::move(one));
  };
  add({.name = "none: a move to the limit", .failure = none}, 0.0, 0.0);
  add({.name = "pushed by 900 N until it reacts", .failure = with([](Failure& f) { f.push_N = 900.0; })}, 0.0,
      0.0);
  add({.name = "encoder reports the loss of its signal",
       .failure = encoder([](EncoderReading& r) { r.valid = false; })},
      0.0, kFree_J);
  add({.name = "encoder stands still", .failure = frozen()}, 0.0, kFree_J);
  add({.name = "encoder runs backwards", .failure = reversed()}, 0.0, kFree_J);
  add({.name = "over-current for 1 ms", .failure = measured(30.0F, true, 0.001)}, 0.0, 0.0);
  add({.name = "over-current that stays", .failure = measured(30.0F, true, 10.0)}, 0.0, kFree_J);
  add({.name = "current measurement lost", .failure = measured(0.0F, false, 10.0)}, 0.0, 0.0);
  add({.name = "amplifier reports a fault, no force",
       .failure = with([](Failure& f) { f.amplifier_dead = f.amplifier_reports = true; })},
      0.0, kFree_J);
  add({.name = "DC link falls to 30 V", .failure = with([](Failure& f) { f.link_V = 30.0; })}, 0.0, 0.0);
  add({.name = "DC link rises to 65 V", .failure = with([](Failure& f) { f.link_V = 65.0; })}, 0.0, kFree_J);
  // Noticed only by what the carriage does: once when it should brake, and once more when it does not.
  add({.name = "amplifier without force, silent",
       .failure = with([](Failure& f) { f.amplifier_dead = true; })},
      25.0, kFree_J);
  add({.name = "cable pulled, csp", .mode = kCyclicPosition, .failure = none, .master_silent = true}, 0.0,
      0.0);
  add({.name = "SYNC lost, csp", .mode = kCyclicPosition, .failure = none, .sync_lost = true}, 0.0, 0.0);
  add({.name = "master goes on beyond the limit, csp", .mode = kCyclicPosition, .failure = none}, 0.0, 0.0);
  add({.name = "cable pulled, csv", .mode = kCyclicVelocity, .failure = none, .master_silent = true}, 0.0,
      0.0);
  add({.name = "SYNC lost, csv", .mode = kCyclicVelocity, .failure = none, .sync_lost = true}, 0.0, 0.0);
  add({.name = "master goes on beyond the limit, csv", .mode = kCyclicVelocity, .failure = none}, 0.0, 0.0);
  add({.name = "encoder runs backwards, csv", .mode = kCyclicVelocity, .failure = reversed()}, 0.0, kFree_J);
  add({.name = "target stays, pv", .mode = kProfileVelocity, .failure = none}, 0.0, 0.0);
  add({.name = "cable pulled, pv", .mode = kProfileVelocity, .failure = with([](Failure& f) {
                                                               f.cable_pulled = true;
                                                             })},
      0.0, 0.0);
  add({.name = "encoder runs backwards, pv", .mode = kProfileVelocity, .failure = reversed()}, 0.0, kFree_J);
  add({.name = "main loop hangs, pv", .mode = kProfileVelocity, .failure = with([](Failure& f) {
                                                                  f.main_loop_dead = true;
                                                                })},
      0.0, 0.0);
  add({.name = "cable pulled, cst, force stays",
       .mode = kCyclicTorque,
       .failure = none,
       .master_silent = true,
       .force = 800.0},
      0.0, 0.0);
  add({.name = "master pushes on, cst", .mode = kCyclicTorque, .failure = none, .force = 800.0}, 0.0, 0.0);
  add({.name = "limit switch instead of 607Dh", .failure = none, .has_limit = false, .has_switch = true}, 0.0,
      0.0);
  add({.name = "limit switch instead of 607Dh, csp",
       .mode = kCyclicPosition,
       .failure = none,
       .has_limit = false,
       .has_switch = true},
      0.0, 0.0);
  add({.name = "limit switch instead of 607Dh, csv",
       .mode = kCyclicVelocity,
       .failure = none,
       .has_limit = false,
       .has_switch = true},
      0.0, 0.0);
  add({.name = "limit switch instead of 607Dh, pv",
       .mode = kProfileVelocity,
       .failure = none,
       .has_limit = false,
       .has_switch = true},
      0.0, 0.0);
  // The axis runs after them as fast as it may.
  add({.name = "the same, csp, set-points 0.5 m ahead",
       .mode = kCyclicPosition,
       .failure = none,
       .has_limit = false,
       .has_switch = true,
       .ahead_m = 0.5},
      0.0, 0.0);
  add({.name = "limit switch instead of 607Dh, cst",
       .mode = kCyclicTorque,
       .failure = none,
       .has_limit = false,
       .has_switch = true,
       .force = 800.0},
      0.0, 0.0);
  add({.name = "main loop hangs, pp", .failure = with([](Failure& f) { f.main_loop_dead = true; })}, 0.0,
      0.0);
  add({.name = "tick hangs until the watchdog", .failure = with([](Failure& f) { f.tick_dead = true; })},
      12.0, kFree_J);
  return all;
}

Outcome run(const Case& one, bool has_brake) {
  Machine machine(has_brake, one.has_limit);
  if (one.has_switch) machine.add_switch();
  Master402 master(machine, one);
  master.begin();
  // What bridges a stream that fails to come adds up to three periods.
  const bool streams = one.mode == Drive402::kCyclicPosition || one.mode == Drive402::kCyclicVelocity;
  const double way_m = kStop_m + (streams ? 3.0 * 0.002 * kSpeed_mps : 0.0);
  const double fault_m = (one.has_switch ? kSwitch_m : kLimit_m - way_m) - 0.002;
  std::int64_t tick = 0;
  for (; machine.position_m() < fault_m && tick < 30000; ++tick) {
    master.step(tick, false);
    machine.tick(nullptr, 0.0);
  }
  EXPECT_NEAR(machine.velocity_mps(), kSpeed_mps, 0.1) << one.name;
  Outcome outcome;
  bool at_stop = false;
  for (int after = 0; after < 30000; ++after, ++tick) {
    master.step(tick, true);
    machine.tick(&one.failure, after * kTick_s);
    const double v = machine.velocity_mps();
    outcome.peak_mps = std::max(outcome.peak_mps, std::abs(v));
    outcome.farthest_m = std::max(outcome.farthest_m, machine.position_m());
    if (!at_stop && machine.position_m() >= kEndStop_m) {
      at_stop = true;
      outcome.energy_J = 0.5 * kMass_kg * v * v;
      break;
    }
  }
  outcome.fault = machine.bench().loop->controller().state().faults().latched();
  return outcome;
}

std::string table() {
  std::string text;
  const auto print = printer_to(text);
  print("%-40s %6s  %16s %16s\n", "", "", "with brake", "without");
  print("%-40s %6s  %8s %7s %8s %7s\n", "fault", "code", "end, mm", "J", "end, mm", "J");
  for (const Case& one : cases()) {
    const Outcome with_brake = run(one, true);
    const Outcome without = run(one, false);
    print("%-40s %6s ", one.name.c_str(), "");
    text.resize(text.size() - 7);
    if (with_brake.fault == Fault::kNone) {
      print("%6s ", "-");
    } else {
      print("%6X ", static_cast<unsigned>(error_code(with_brake.fault)));
    }
    for (const Outcome& outcome : {with_brake, without}) {
      if (outcome.energy_J > 0.0) {
        print(" %8s %7.1f", "stop", outcome.energy_J);
      } else {
        print(" %8.0f %7.1f", 1e3 * (outcome.farthest_m - kLimit_m), 0.0);
      }
    }
    text += "\n";
  }
  return text;
}

}  // namespace slipstack::energy
