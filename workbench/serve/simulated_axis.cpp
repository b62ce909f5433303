// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/simulated_axis.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "hal/host/board.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "sim_host/motion/set_points.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/controller/simulated_drive.h"
#include "workbench/loop/axis_options.h"

namespace slipstack::workbench {
namespace {

constexpr std::uint8_t kNode = 5;

std::vector<sim::EffectId> effects_in(const SimulatedAxis& axis) {
  return axis.effects == "random" ? sim::draw_effect_ids(1, axis.seed) : effects_of(axis.effects);
}

struct Drawn {
  sim::Bench bench;
  sim::MotionProgramme programme;
};

Drawn draw(const SimulatedAxis& axis) {
  Drawn drawn{sim::draw_bench(sim::Setup::kPickAndPlace, axis.seed), {}};
  if (!(axis.seconds >= 8.0 && axis.seconds <= 600.0)) {
    throw UsageError("seconds: must be between 8 and 600");
  }
  check_strength(axis.strength);
  drawn.bench.programme.seconds = axis.seconds;
  drawn.programme = sim::draw_programme(drawn.bench, axis.seed);
  sim::add_effects(drawn.bench.axis, effects_in(axis), drawn.programme, drawn.bench.rate_Hz, axis.strength,
                   axis.seed);
  return drawn;
}

sim::MotionProgramme programme_of(const std::string& path, const sim::Axis& axis) {
  sim::SetPointFile points;
  try {
    points = sim::read_set_points(path);
  } catch (const std::runtime_error& error) {
    throw InputError(printable(error.what()));
  }
  for (const double position_m : points.position_m) {
    if (!(position_m >= 0.0 && position_m <= axis.stroke_m)) {
      throw UsageError(
          fmt::format("the plan leaves the stroke of the simulated axis, 0 to {:.4g} m; plan with "
                      "a stroke within it",
                      axis.stroke_m));
    }
  }
  sim::MotionProgramme programme;
  programme.append(sim::make_sampled(std::move(points.position_m), points.rate_Hz));
  return programme;
}

}  // namespace

/// The master's end of a cable to a drive in this process.
class SimulatedCable final : public CanLink {
 public:
  SimulatedCable(host::HostCanPort& port, SimulatedDrive& drive) : port_(port), drive_(drive) {}
  void send(const CanFrame& frame) override { port_.send(frame); }
  bool receive(CanFrame& frame, int timeout_ms) override {
    constexpr int kTicksPerMillisecond = 10;
    for (int tick = 0; tick <= kTicksPerMillisecond * timeout_ms; ++tick) {
      if (port_.receive(frame)) return true;
      if (timeout_ms > 0) drive_.step();
    }
    return false;
  }
  std::string name() const override { return "simulated axis"; }

 private:
  host::HostCanPort& port_;
  SimulatedDrive& drive_;
};

std::string record_simulated_axis(const SimulatedAxis& axis, const std::string& set_points) {
  const Drawn drawn = draw(axis);
  const sim::Axis& plant = drawn.bench.axis;
  if (set_points.empty()) {
    return sim::log_as_csv(plant, sim::simulate_log(plant, drawn.programme, drawn.bench.rate_Hz, axis.seed));
  }
  const sim::MotionProgramme asked = programme_of(set_points, plant);
  return sim::log_as_csv(plant, sim::simulate_log(plant, asked, drawn.bench.rate_Hz, axis.seed + 1));
}

std::string hidden_in(const SimulatedAxis& axis) {
  std::vector<std::string> names;
  for (const sim::EffectId id : effects_in(axis)) names.emplace_back(sim::name(id));
  return names.empty() ? "none" : joined(names);
}

struct SimulatedController::Parts {
  sim::Bench bench;
  host::HostNonvolatile flash{2, 2048, 8};
  host::HostCanPort device{4096};
  host::HostCanPort port{4096};
  std::unique_ptr<SimulatedDrive> drive;
  std::unique_ptr<SimulatedCable> cable;
  std::unique_ptr<SdoClient> client;
};

SimulatedController::SimulatedController(const SimulatedAxis& axis) : parts_(std::make_unique<Parts>()) {
  parts_->bench = draw(axis).bench;
  parts_->port.connect(parts_->device);
  parts_->drive =
      std::make_unique<SimulatedDrive>(parts_->bench.axis, parts_->device, parts_->flash, kNode, axis.seed);
  parts_->cable = std::make_unique<SimulatedCable>(parts_->port, *parts_->drive);
  parts_->client = std::make_unique<SdoClient>(*parts_->cable, kNode);
  for (int tick = 0; tick < 20; ++tick) parts_->drive->step();
}

SimulatedController::~SimulatedController() = default;

SdoClient& SimulatedController::client() {
  return *parts_->client;
}

}  // namespace slipstack::workbench
