// SPDX-License-Identifier: Apache-2.0
// Plan, run, deploy.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sim_host/motion/set_points.h"
#include "workbench/analysis/plan_motion.h"
#include "workbench/base/atomic_write.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/can/client/socket_link.h"
#include "workbench/can/commands/master.h"
#include "workbench/report/json_values.h"
#include "workbench/serve/live/driven_axis.h"
#include "workbench/serve/live/tracking_error.h"
#include "workbench/serve/session/plain_file.h"
#include "workbench/serve/session/workspace.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

constexpr std::size_t kLargestAxisFile = std::size_t{1} << 16;  // of simulated_axis.json

std::filesystem::path axis_file(const Session& session) {
  return session.folder() / "simulated_axis.json";
}

using Wait = SimulatedController::Wait;

constexpr double kMostTravel_m = 1.0;  // of a move that is asked for in the browser
constexpr int kMostMoves = 1000;
constexpr double kLeastRate_Hz = 10.0;  // as for slipstack record
constexpr double kMostRate_Hz = 2000.0;

void check_node(int node) {
  if (node < 1 || node > 127) throw UsageError("the node id must be between 1 and 127");
}

void check_travel(double travel_m) {
  if (travel_m >= 0.0 && travel_m <= kMostTravel_m) return;
  throw UsageError(fmt::format("the travel must be between 0 and {:g} mm", 1e3 * kMostTravel_m));
}

json tracking_json(const TrackingError& found) {
  return {{"time_s", found.time_s},
          {"reference_m", found.reference_m},
          {"error_m", found.error_m},
          {"rms_m", found.rms_m},
          {"largest_m", found.largest_m}};
}

/// A controller is not watched during the life of this.
class Paused {
 public:
  explicit Paused(LiveNode& live) : live_(live) { live_.pause(); }
  Paused(const Paused&) = delete;
  Paused& operator=(const Paused&) = delete;
  ~Paused() { live_.resume(); }

 private:
  LiveNode& live_;
};

std::filesystem::path plan_file(const Session& session) {
  return session.folder() / "plan.csv";
}

}  // namespace

json Workspace::simulated_axis_json() const {
  if (!std::filesystem::exists(axis_file(session_))) return nullptr;
  try {
    return json::parse(read_whole(axis_file(session_), kLargestAxisFile));
  } catch (const std::exception&) {
    return nullptr;
  }
}

SimulatedAxis Workspace::simulated_axis() const {
  const std::lock_guard lock(lock_);
  const json stored = simulated_axis_json();
  if (stored.is_null()) {
    throw UsageError(
        "this session has no simulated axis; start one, or run the plan on your axis and add its log");
  }
  return {stored.at("seed"), stored.at("effects"), stored.at("strength"), stored.at("seconds"),
          stored.value("setup", SimulatedAxis{}.setup)};
}

void Workspace::start_simulated_axis(const SimulatedAxis& axis) {
  static_cast<void>(hidden_in(axis));  // throws for an unknown effect
  jobs_.start("record the simulated axis", [this, axis](Progress& progress) {
    progress.show("the axis moves");
    const std::string log = record_simulated_axis(axis, "");
    std::vector<std::string> paths;
    {
      const std::lock_guard lock(lock_);
      write_atomically(axis_file(session_), own_json_text({{"seed", axis.seed},
                                                           {"effects", axis.effects},
                                                           {"strength", axis.strength},
                                                           {"seconds", axis.seconds},
                                                           {"setup", axis.setup}}));
      paths = session_.logs();
      paths.push_back(session_.store_log(fmt::format("simulated-{}.csv", axis.seed), log));
      session_.set_logs(paths);
    }
    disconnect_simulated();
    open(paths, progress);
  });
}

void Workspace::plan(const json& wanted) {
  PlanRequest request;
  {
    const std::lock_guard lock(lock_);
    const Version* now = session_.current();
    if (now == nullptr) throw UsageError("fit a first model before an experiment is planned");
    request.logs = session_.logs();
    request.model = session_.model_path(now->id).string();
  }
  request.effects = wanted.at("for");
  request.limits = wanted.value("limits", "");
  request.seconds = wanted.value("seconds", 30.0);
  request.rate_Hz = wanted.value("rate_Hz", 1000.0);
  check_plan(request);
  jobs_.start("plan the next experiment", [this, request](Progress& progress) {
    ExperimentResult result;
    try {
      result = plan_motion(request, progress);
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
    json page = result_json(result);
    page["text"] = result_text(result);
    page["charts"] = result_report(result, "").value("charts", json::array());
    throw_if_cancelled();
    const std::lock_guard lock(lock_);
    write_atomically(plan_file(session_), result.file);
    plan_ = std::move(page);
  });
}

void Workspace::run_plan() {
  const SimulatedAxis axis = simulated_axis();
  {
    const std::lock_guard lock(lock_);
    if (!std::filesystem::exists(plan_file(session_))) throw UsageError("plan an experiment first");
  }
  jobs_.start("run the plan on the simulated axis", [this, axis](Progress& progress) {
    progress.show("the axis moves");
    const std::string log = record_simulated_axis(axis, plan_file(session_).string());
    throw_if_cancelled();
    std::vector<std::string> paths;
    {
      const std::lock_guard lock(lock_);
      paths = session_.logs();
      paths.push_back(session_.store_log("planned.csv", log));
      session_.set_logs(paths);
    }
    open(paths, progress);
  });
}

/// A link to a CAN interface, or, without a name, to the bus of the simulated axis.
std::unique_ptr<CanLink> Workspace::link_to(const std::string& bus, SimulatedController::Wait wait) {
  if (!bus.empty()) return open_link(bus, "CAN interface");
  const std::lock_guard lock(controller_lock_);
  if (!controller_) controller_ = std::make_unique<SimulatedController>(simulated_axis());
  return controller_->connect(wait);
}

/// Calls `work` with the node on that bus.
template <class Work>
void Workspace::with_controller(const std::string& bus, int node, SimulatedController::Wait wait,
                                Work&& work) {
  check_node(node);
  const std::unique_ptr<CanLink> link = link_to(bus, wait);
  SdoClient drive(*link, static_cast<std::uint8_t>(node), &talking_);
  drive.await_node();
  work(drive);
}

json Workspace::controller(int version, const std::string& bus, int node) {
  Model model;
  {
    const std::lock_guard lock(lock_);
    model = read_controller_model(session_.model_path(version));
  }
  json answer;
  with_controller(bus, node, Wait::as_fast_as_possible, [&](SdoClient& drive) {
    json list = json::array();
    for (const ModelDifference& one :
         differences_from_drive(drive, model, [](const std::string&, double) {})) {
      list.push_back({{"object", fmt::format("{:04X}h:{:02X} {}", one.index, one.sub, one.object)},
                      {"unit", one.unit},
                      {"on_drive", number_json(one.on_drive)},
                      {"in_model", number_json(one.in_model)}});
    }
    answer = {{"differences", list},
              {"status", drive_status(drive)},
              {"hash", fmt::format("{:08x}", target_hash(model))}};
  });
  return answer;
}

/// What was planned last: the file that the user may have, and the figures that the page shows of it.
DriveMotion Workspace::planned_motion() const {
  const std::lock_guard lock(lock_);
  if (plan_.is_null() || !std::filesystem::exists(plan_file(session_)))
    throw UsageError("plan an experiment first");
  DriveMotion motion;
  try {
    sim::SetPointFile points = sim::read_set_points(plan_file(session_).string());
    motion.position_m = std::move(points.position_m);
    motion.rate_Hz = points.rate_Hz;
  } catch (const std::runtime_error& error) {
    throw InputError(printable(error.what()));
  }
  const json& summary = plan_.at("summary");
  const auto value = [](const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  motion.velocity_mps = value(summary, "velocity_mps");
  motion.acceleration_mps2 = value(summary, "acceleration_mps2");
  motion.force_N = value(summary, "force_N");
  const json log = summary.value("log", json::object());
  motion.log_low_m = value(log, "low_m");
  motion.log_high_m = value(log, "high_m");
  return motion;
}

PlanSampling Workspace::plan_sampling() const {
  const std::lock_guard lock(lock_);
  return log_heads_.empty() ? PlanSampling{} : sampling_for(log_heads_.front().at("sample_rate_Hz"));
}

json Workspace::plan_on_controller() {
  DriveMotion motion = planned_motion();
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  motion.places_known = now->target().bus.empty();
  PlanOnAxis found;
  with_controller(now->target().bus, now->target().node, Wait::real_time,
                  [&](SdoClient& drive) { found = check_plan_on(drive, motion); });
  json limits = json::array();
  for (const PlanLimit& one : found.limits) {
    limits.push_back({{"quantity", one.quantity},
                      {"unit", one.unit},
                      {"planned", number_json(one.planned)},
                      {"allowed", number_json(one.allowed)},
                      {"fits", one.fits},
                      {"source", one.source}});
  }
  return {{"limits", limits},
          {"refused", found.refused},
          {"begin_m", found.begin_m},
          {"now_m", found.now_m},
          {"low_m", std::min(motion.low_m(), found.now_m)},
          {"high_m", std::max(motion.high_m(), found.now_m)},
          {"rate_Hz", plan_sampling().rate_Hz()},
          {"duration_s", static_cast<double>(motion.position_m.size()) / motion.rate_Hz}};
}

void Workspace::run_plan_on_controller(bool alone) {
  DriveMotion motion = planned_motion();
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  motion.places_known = now->target().bus.empty();
  const PlanSampling sampling = plan_sampling();
  jobs_.start("run the plan on the controller", [this, now, motion, sampling, alone](Progress& progress) {
    std::string log;
    {
      // The stream that is watched and that of the set-points use the same SYNC and PDOs.
      const Paused paused(*now);
      with_controller(
          now->target().bus, now->target().node, Wait::as_fast_as_possible, [&](SdoClient& drive) {
            const Show show = [&](const std::string& stage, double f) { progress.show(stage, f); };
            log = run_plan_on(drive, motion, sampling, show).log;
          });
    }
    std::vector<std::string> paths;
    {
      const std::lock_guard lock(lock_);
      if (!alone) paths = session_.logs();
      paths.push_back(session_.store_log(fmt::format("planned-node{}.csv", now->target().node), log));
      session_.set_logs(paths);
    }
    open(paths, progress);
  });
}

json Workspace::tracking() const {
  const std::lock_guard lock(lock_);
  return tracking_;
}

void Workspace::deploy(int version, const std::string& bus, int node, double travel_m) {
  check_travel(travel_m);
  std::string path;
  {
    const std::lock_guard lock(lock_);
    path = session_.model_path(version).string();
  }
  const Model model = read_controller_model(path);
  jobs_.start("deploy", [this, model, path, version, bus, node, travel_m](Progress& progress) {
    std::string text;
    json tracking;
    const Show show = [&](const std::string& stage, double f) { progress.show(stage, f); };
    const std::shared_ptr<LiveNode> watched = live();
    const bool watching = watched && watched->target().bus == bus && watched->target().node == node;
    with_controller(bus, node, Wait::as_fast_as_possible, [&](SdoClient& drive) {
      const auto move = [&](const char* when) {
        if (travel_m > 0.0) tracking[when] = tracking_json(record_tracking_error(drive, travel_m, show));
      };
      move("before");
      text = deploy_model(drive, model, path, true, show);
      if (watching) watched->model_changed(fmt::format("version {}", version));
      move("after");
    });
    const std::lock_guard lock(lock_);
    deployed_ = std::move(text);
    tracking_ = std::move(tracking);
  });
}

/// The simulated axis is another from now on.
void Workspace::disconnect_simulated() {
  const std::shared_ptr<LiveNode> now = live();
  if (now && now->target().bus.empty()) drop_live();
  const std::lock_guard lock(controller_lock_);
  controller_.reset();
}

std::shared_ptr<LiveNode> Workspace::live() const {
  const std::lock_guard lock(lock_);
  return live_;
}

void Workspace::connect(const LiveNode::Target& target) {
  check_node(target.node);
  if (!(target.rate_Hz >= kLeastRate_Hz && target.rate_Hz <= kMostRate_Hz)) {
    throw UsageError(fmt::format("rate_Hz: must be between {:g} and {:g} Hz, what a bus carries",
                                 kLeastRate_Hz, kMostRate_Hz));
  }
  if (target.bus.empty()) static_cast<void>(simulated_axis());  // throws where there is none
  disconnect();                                                 // throws while a job runs
  auto next = std::make_shared<LiveNode>(events_, talking_, target,
                                         [this, target] { return link_to(target.bus, Wait::real_time); });
  {
    const std::lock_guard lock(lock_);
    live_ = std::move(next);
  }
  events_.tell();
}

void Workspace::disconnect() {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  drop_live();
}

void Workspace::drop_live() {
  std::shared_ptr<LiveNode> gone;
  {
    const std::lock_guard lock(lock_);
    gone.swap(live_);
  }
  gone.reset();  // waits for its thread, which may ask for the lock
  events_.tell();
}

void Workspace::start_recording() {
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  now->start_recording();
}

void Workspace::keep_recording(bool alone) {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  const Recording recording = now->stop_recording();
  std::vector<std::string> paths;
  {
    const std::lock_guard lock(lock_);
    if (!alone) paths = session_.logs();
    paths.push_back(session_.store_log(fmt::format("node{}.csv", now->target().node), recording.log));
  }
  set_logs(std::move(paths));
}

void Workspace::reset_fault() {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  with_controller(now->target().bus, now->target().node, Wait::real_time, [](SdoClient& drive) {
    for (const std::uint32_t word : {0x00U, 0x80U, 0x00U}) drive.write(0x6040, 0, word, 2);
  });
}

void Workspace::move_axis(double travel_m, int times) {
  check_travel(travel_m);
  if (travel_m == 0.0 || times < 1 || times > kMostMoves) {
    throw UsageError(fmt::format("a move needs a travel, and between 1 and {} times", kMostMoves));
  }
  const std::shared_ptr<LiveNode> now = live();
  if (!now) throw UsageError("no controller is connected; connect to one first");
  jobs_.start("move the axis", [this, target = now->target(), travel_m, times](Progress& progress) {
    with_controller(target.bus, target.node, Wait::real_time, [&](SdoClient& drive) {
      move_to_and_fro(drive, travel_m, times,
                      [&](const std::string& stage, double f) { progress.show(stage, f); });
    });
  });
}

}  // namespace slipstack::workbench
