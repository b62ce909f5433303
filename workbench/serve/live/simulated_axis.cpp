// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/simulated_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <mutex>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "hal/host/board.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "sim_host/motion/set_points.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/can/host_node/simulated_drive.h"
#include "workbench/loop/axis_options.h"

namespace slipstack::workbench {
namespace {

constexpr std::uint8_t kNode = 5;

std::vector<sim::EffectId> effects_in(const SimulatedAxis& axis) {
  return effects_by_seed(axis.effects, axis.seed);
}

struct Drawn {
  sim::Bench bench;
  sim::MotionProgramme programme;
};

sim::Setup setup_of(const SimulatedAxis& axis) {
  if (axis.setup == "pick_and_place") return sim::Setup::kPickAndPlace;
  if (axis.setup == "random") return sim::Setup::kRandom;
  throw UsageError(fmt::format("setup: {} is neither pick_and_place nor random", in_quotes(axis.setup)));
}

Drawn draw(const SimulatedAxis& axis) {
  Drawn drawn{sim::draw_bench(setup_of(axis), axis.seed), {}};
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

/// The drive, and a queue for each master.
class SimulatedBus {
 public:
  /// What a master has not received yet, of what it listens to.
  struct Queue {
    std::vector<std::uint32_t> ids;  ///< empty: all
    std::deque<CanFrame> frames;
  };

  explicit SimulatedBus(const SimulatedAxis& axis) : bench_(draw(axis).bench) {
    port_.connect(device_);
    drive_ = std::make_unique<SimulatedDrive>(bench_.axis, device_, flash_, kNode, axis.seed);
    for (int tick = 0; tick < 20; ++tick) drive_->step();
  }
  std::shared_ptr<Queue> add_master() {
    const std::lock_guard lock(lock_);
    queues_.push_back(std::make_shared<Queue>());
    return queues_.back();
  }
  void remove_master(const std::shared_ptr<Queue>& queue) {
    const std::lock_guard lock(lock_);
    std::erase(queues_, queue);
  }
  void listen_to(Queue& queue, std::span<const std::uint32_t> ids) {
    const std::lock_guard lock(lock_);
    queue.ids.assign(ids.begin(), ids.end());
  }
  void send(const CanFrame& frame) {
    const std::lock_guard lock(lock_);
    port_.send(frame);
  }
  /// The next frame of a master, at once or within some ticks.
  bool receive(Queue& queue, CanFrame& frame, int ticks) {
    const std::lock_guard lock(lock_);
    for (; !take(queue, frame); --ticks) {
      if (ticks == 0) return false;
      drive_->step();
    }
    return true;
  }
  /// The next frame of a master, if there is one until now.
  bool receive_by_now(Queue& queue, CanFrame& frame) {
    const std::lock_guard lock(lock_);
    const auto now = Clock::now();
    passed_ = std::max(passed_, now - kMostBehind);
    for (; !take(queue, frame); passed_ += kTick) {
      if (passed_ + kTick > now) return false;
      drive_->step();
    }
    return true;
  }

 private:
  static constexpr std::size_t kMostWaiting = 65536;  // of a master that does not look; then the oldest goes

  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds kTick{100};
  static constexpr std::chrono::milliseconds kMostBehind{100};  // of a machine that was busy with other work

  bool take(Queue& queue, CanFrame& frame) {
    CanFrame sent;
    while (port_.receive(sent)) {
      for (const auto& each : queues_) {
        const auto& ids = each->ids;
        if (!ids.empty() && std::find(ids.begin(), ids.end(), sent.id) == ids.end()) continue;
        if (each->frames.size() == kMostWaiting) each->frames.pop_front();
        each->frames.push_back(sent);
      }
    }
    if (queue.frames.empty()) return false;
    frame = queue.frames.front();
    queue.frames.pop_front();
    return true;
  }

  std::mutex lock_;
  sim::Bench bench_;
  host::HostNonvolatile flash_{2, 2048, 8};
  host::HostCanPort device_{4096};
  host::HostCanPort port_{4096};
  std::unique_ptr<SimulatedDrive> drive_;
  std::vector<std::shared_ptr<Queue>> queues_;
  Clock::time_point passed_ =
      Clock::now();  ///< until then the axis has moved for those who wait in real time
};

namespace {

/// A master's end.
class SimulatedLink final : public CanLink {
 public:
  SimulatedLink(std::shared_ptr<SimulatedBus> bus, SimulatedController::Wait wait)
      : bus_(std::move(bus)), queue_(bus_->add_master()), wait_(wait) {}
  SimulatedLink(const SimulatedLink&) = delete;
  SimulatedLink& operator=(const SimulatedLink&) = delete;
  ~SimulatedLink() override { bus_->remove_master(queue_); }
  void send(const CanFrame& frame) override { bus_->send(frame); }
  bool receive(CanFrame& frame, int timeout_ms) override {
    if (wait_ == SimulatedController::Wait::as_fast_as_possible) {
      constexpr int kTicksPerMillisecond = 10;
      return bus_->receive(*queue_, frame, kTicksPerMillisecond * timeout_ms);
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
    while (!bus_->receive_by_now(*queue_, frame)) {
      if (std::chrono::steady_clock::now() >= end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  void listen_to(std::span<const std::uint32_t> ids) override { bus_->listen_to(*queue_, ids); }
  std::string name() const override { return "simulated axis"; }

 private:
  std::shared_ptr<SimulatedBus> bus_;
  std::shared_ptr<SimulatedBus::Queue> queue_;
  SimulatedController::Wait wait_;
};

}  // namespace

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
  return names_of(effects_in(axis));
}

SimulatedController::SimulatedController(const SimulatedAxis& axis)
    : bus_(std::make_shared<SimulatedBus>(axis)) {}

SimulatedController::~SimulatedController() = default;

std::unique_ptr<CanLink> SimulatedController::connect(Wait wait) {
  return std::make_unique<SimulatedLink>(bus_, wait);
}

}  // namespace slipstack::workbench
