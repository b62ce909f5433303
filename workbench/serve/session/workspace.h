// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/long_logs/processes/process_group.h"
#include "workbench/serve/http/bytes.h"
#include "workbench/serve/http/events.h"
#include "workbench/serve/live/live_node.h"
#include "workbench/serve/live/plan_on_axis.h"
#include "workbench/serve/live/simulated_axis.h"
#include "workbench/serve/session/jobs.h"
#include "workbench/serve/session/session.h"
#include "workbench/serve/views/trace.h"
#include "workbench/serve/views/view.h"

namespace slipstack::workbench {

/// A file to be saved by the browser.
struct Download {
  std::string name;
  std::string type;  ///< media type
  std::string content;
};

/// A log by its name, and how it was sampled.
struct SampledLog {
  std::string name;
  double sample_rate_Hz = 0.0;
};

/// Throws InputError where the logs have different sampling rates; it names the logs of each rate.
void require_one_rate(const std::vector<SampledLog>& logs);

/// One session that is being worked on: what the pages show and what they can ask for. Long work runs as a
/// job on its own copy of the logs, as the command line would do it; its result joins the session at the end.
/// So whatever fails or is cancelled leaves everything as it was. All members may be called from any thread
/// and throw UsageError and InputError, one line each.
class Workspace {
 public:
  Workspace(ProcessGroup& group, const std::filesystem::path& folder);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  /// Logs, history, job, diagnosis of the current version: all that is small.
  nlohmann::json state() const;
  Events& events() { return events_; }
  const std::filesystem::path& folder() const { return session_.folder(); }

  // Logs.
  /// Opens the session's logs and draws them: first as recorded, then as measured. A job.
  void open_logs();
  void set_logs(std::vector<std::string> paths);
  /// Stores an uploaded log, which is a log of the documented format, and opens it with the others.
  void add_log(const std::string& name, const std::string& content);
  void remove_log(std::size_t index);

  // Pictures.
  Bytes picture(std::size_t log, const std::string& signal, double from_s, double to_s,
                std::size_t points) const;
  Bytes rows() const;
  Bytes model(int version) const;
  nlohmann::json charts(int version, int other) const;
  nlohmann::json worth(int version) const;
  nlohmann::json with_candidate(int version, const std::string& effect) const;
  /// `changes`: [{effect, kind: gain | shape | factor, index, value}].
  nlohmann::json adjustable_parameters(int version) const;
  Bytes bent(int version, const nlohmann::json& changes) const;

  // The model. Each is a job but the last.
  void fit(const std::vector<std::string>& effects);
  void add(const std::string& effect);
  void remove(const std::string& effect);
  void diagnose(const std::vector<std::string>& user_effects);
  void keep_bent(int version, const nlohmann::json& changes);

  // History.
  void select(int version);
  void undo();
  void redo();
  void set_notes(const std::string& text);
  std::string notes() const;

  // Experiments.
  void start_simulated_axis(const SimulatedAxis& axis);
  void plan(const nlohmann::json& wanted);
  /// Runs the plan on the simulated axis; the log joins the others.
  void run_plan();
  /// The plan against the limits of the axis of the live controller (plan_on_axis.h): {limits, refused,
  /// begin_m, now_m, low_m, high_m, rate_Hz, duration_s}.
  nlohmann::json plan_on_controller();
  /// Runs the plan on that axis; the log joins the others, or takes their place. A job; watching pauses.
  void run_plan_on_controller(bool alone);
  /// What a deployment would change on the controller; `bus`: empty for the simulated drive, else a CAN
  /// interface.
  nlohmann::json controller(int version, const std::string& bus, int node);
  /// `travel_m`: the axis is moved so far to and fro before and after; 0: it is not moved.
  void deploy(int version, const std::string& bus, int node, double travel_m);
  /// Position error of the axis in a move before and after the last deployment, or null.
  nlohmann::json tracking() const;

  // A controller that is watched while it runs (live_node.h).
  void connect(const LiveNode::Target& target);
  void disconnect();
  void start_recording();
  /// Ends the recording; its log joins the others, or takes their place.
  void keep_recording(bool alone);
  /// Moves the axis of the live controller to and fro. A job.
  void move_axis(double travel_m, int times);
  /// Resets a fault of the live controller (bit 7 of 6040h); nothing moves.
  void reset_fault();
  /// The live controller, or nullptr.
  std::shared_ptr<LiveNode> live() const;

  Download download(const std::string& what, int version, const nlohmann::json& options) const;

  Jobs& jobs() { return jobs_; }

 private:
  LogRequest request() const;
  nlohmann::json simulated_axis_json() const;
  SimulatedAxis simulated_axis() const;
  DriveMotion planned_motion() const;
  /// Sampling of a log along the plan, at the rate of the open logs where a bus can carry it.
  PlanSampling plan_sampling() const;
  void drop_live();
  void disconnect_simulated();
  std::unique_ptr<CanLink> link_to(const std::string& bus, SimulatedController::Wait wait);
  template <class Work>
  void with_controller(const std::string& bus, int node, SimulatedController::Wait wait, Work&& work);
  std::string log_names() const;
  std::shared_ptr<View> view() const;
  Terms terms(int version) const;
  Terms bent_terms(int version, const nlohmann::json& changes) const;
  /// The logs for one job: a copy of those that are open, which need not be read and weighed again.
  LogSearch search(Progress& progress) const;
  /// The version that is shown, and its model.
  struct Current {
    int version = 0;
    Model model;
  };
  /// Throws UsageError(`none`) where there is no version yet.
  Current current(const char* none);
  void open(const std::vector<std::string>& paths, Progress& progress);
  void add_tried(nlohmann::json card);
  void publish(int parent, const std::string& what, const Model& model, double before_N);
  /// The answer that is shown while a job refines it: the same effects, their gains fitted, the shapes held.
  struct FirstAnswer {
    int id = 0;  ///< below zero, where no version is
    int parent = 0;
    std::string what;
    View::Gains gains;
    double floor_N = 0.0;
    bool ended = false;  ///< no longer shown; pages may still be asking for it
  };
  nlohmann::json first_answer_json() const;
  std::optional<Term> known_term(const Measurement& measurement, int version,
                                 const EffectDescription& effect) const;
  /// Shows what `gains` makes of the version for as long as the result lives; nothing where it makes nothing.
  /// The page asks for it by its id like for a version. No file is written: after a crash, or when the job is
  /// cancelled, it has never been.
  class Shown;
  using FirstGains = std::function<std::optional<View::Gains>(View&, const std::string& key)>;
  Shown show_first(const Current& now, const std::string& what, const FirstGains& gains);

  static constexpr const char* kDiagnosis = "find what is missing";  ///< name of that job

  ProcessGroup& group_;
  Events events_;
  mutable std::mutex lock_;  ///< of what follows, held for moments only
  Session session_;
  std::vector<std::shared_ptr<const Trace>> traces_;
  std::vector<nlohmann::json> log_heads_;
  std::shared_ptr<View> view_;
  nlohmann::json plan_;
  nlohmann::json tried_ = nlohmann::json::array();  ///< effects that the last diagnosis has tried
  std::optional<FirstAnswer> first_answer_;
  int first_answers_ = 0;  ///< so far
  std::string deployed_;
  nlohmann::json tracking_;  ///< of the simulated axis, before and after the last deployment
  std::unique_ptr<SimulatedController> controller_;
  std::mutex controller_lock_;
  std::mutex talking_;  ///< held for each transfer with a controller (SdoClient): two would mix
  std::shared_ptr<LiveNode> live_;
  Jobs jobs_;  ///< last: its thread ends before the rest goes
};

}  // namespace slipstack::workbench
