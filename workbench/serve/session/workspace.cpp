// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/workspace.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/estimate/measurement/parts.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/report/html/chart_data.h"
#include "workbench/report/json_values.h"
#include "workbench/serve/session/hand_changes.h"
#include "workbench/serve/views/diagnosis_cards.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

json head_json(const std::string& path, const LongLog& log) {
  const Log& head = log.head();
  json header = json::object();
  for (const auto& [name, value] : head.header) header[name] = value;
  return {{"path", printable(path)},
          {"name", printable(std::filesystem::path(path).filename().string())},
          {"samples", log.sample_count()},
          {"sample_rate_Hz", head.sample_rate_Hz},
          {"duration_s", static_cast<double>(log.sample_count()) / head.sample_rate_Hz},
          {"notes", head.notes},
          {"header", header}};
}

}  // namespace

void require_one_rate(const std::vector<SampledLog>& logs) {
  struct Rate {
    double rate_Hz;
    std::vector<std::string> names;
  };
  std::vector<Rate> rates;
  for (const SampledLog& log : logs) {
    auto found = std::find_if(rates.begin(), rates.end(), [&log](const Rate& rate) {
      return is_same_rate(rate.rate_Hz, log.sample_rate_Hz);
    });
    if (found == rates.end()) found = rates.insert(found, {log.sample_rate_Hz, {}});
    found->names.push_back(printable(log.name));
  }
  if (rates.size() <= 1) return;
  std::vector<std::string> said;
  said.reserve(rates.size());
  for (const Rate& rate : rates)
    said.push_back(fmt::format("{:.6g} Hz: {}", rate.rate_Hz, joined(rate.names)));
  throw InputError(fmt::format(
      "the logs have different sampling rates ({}); close those of all rates but one, or resample "
      "them and open them again",
      fmt::join(said, "; ")));
}

Workspace::Workspace(ProcessGroup& group, const std::filesystem::path& folder)
    : group_(group), session_(folder), jobs_(events_) {}

Workspace::~Workspace() {
  events_.close();
  live_.reset();
}

json Workspace::state() const {
  const std::lock_guard lock(lock_);
  json state = session_.to_json();
  state["logs"] = log_heads_;
  for (std::size_t i = log_heads_.size(); i < session_.logs().size(); ++i) {
    const std::string& path = session_.logs()[i];
    state["logs"].push_back(
        {{"path", printable(path)}, {"name", printable(std::filesystem::path(path).filename().string())}});
  }
  state["traces"] = traces_.size();
  state["measured"] = view_ != nullptr;
  state["job"] = jobs_.to_json();
  if (axis_is_rotary()) state["units"] = rotary_units();
  state["plan"] = plan_;
  state["deployed"] = deployed_;
  const bool diagnosing = state["job"]["running"] == true && state["job"]["what"] == kDiagnosis;
  state["tried"] = diagnosing ? tried_ : json::array();
  state["default_effects"] = default_baseline();
  state["simulated"] = simulated_axis_json();
  state["live"] = live_ ? live_->to_json() : json(nullptr);
  state["first_answer"] = first_answer_json();
  state["diagnosis"] = nullptr;
  if (const Version* now = session_.current()) {
    if (auto found = session_.diagnosis(now->id)) state["diagnosis"] = std::move(*found);
  }
  return state;
}

/// As a version of the session, with what is not yet so of it said in `note`.
json Workspace::first_answer_json() const {
  if (!first_answer_ || first_answer_->ended) return nullptr;
  const FirstAnswer& first = *first_answer_;
  const bool excerpt = view_ != nullptr && view_->measurement().is_excerpt();
  return {{"id", first.id},
          {"parent", first.parent},
          {"what", first.what},
          {"effects", ids_of(first.gains.terms)},
          {"before_N", first.gains.before_N},
          {"after_N", first.gains.after_N},
          {"floor_N", first.floor_N},
          {"note", excerpt ? "gains only, on the excerpt; shapes are being refined"
                           : "gains only; shapes are being refined"}};
}

LogRequest Workspace::request() const {
  const std::lock_guard lock(lock_);
  return {&group_, session_.logs(), {}};
}

std::string Workspace::log_names() const {
  const std::lock_guard lock(lock_);
  return joined(session_.logs());
}

std::shared_ptr<View> Workspace::view() const {
  const std::lock_guard lock(lock_);
  if (!view_) throw UsageError("no log is open yet; open one first");
  return view_;
}

LogSearch Workspace::search(Progress& progress) const {
  std::shared_ptr<View> open;
  {
    const std::lock_guard lock(lock_);
    if (view_ && view_->opened().paths() == session_.logs()) open = view_;
  }
  return open ? LogSearch(open->opened(), progress) : LogSearch(request(), progress);
}

Terms Workspace::terms(int version) const {
  const std::lock_guard lock(lock_);
  if (first_answer_ && first_answer_->id == version) return first_answer_->gains.terms;
  return session_.model(version).terms;
}

void Workspace::open_logs() {
  std::vector<std::string> paths;
  {
    const std::lock_guard lock(lock_);
    paths = session_.logs();
  }
  if (paths.empty()) {
    const std::lock_guard lock(lock_);
    traces_.clear();
    log_heads_.clear();
    view_.reset();
    events_.tell();
    return;
  }
  jobs_.start("open the logs", [this, paths](Progress& progress) { open(paths, progress); });
}

void Workspace::open(const std::vector<std::string>& paths, Progress& progress) {
  {
    const std::lock_guard lock(lock_);
    if (session_.versions().empty()) forget_axis();
    traces_.clear();
    log_heads_.clear();
    view_.reset();
  }
  std::vector<SampledLog> sampled;
  for (const std::string& path : paths) {
    progress.show(fmt::format("read {}", printable(std::filesystem::path(path).filename().string())));
    const LongLog log = LongLog::open(path);
    sampled.push_back({std::filesystem::path(path).filename().string(), log.head().sample_rate_Hz});
    auto trace = std::make_shared<const Trace>(log);
    const std::lock_guard lock(lock_);
    traces_.push_back(std::move(trace));
    log_heads_.push_back(head_json(path, log));
    events_.tell();  // the first picture need not wait for what follows
  }
  Jobs::give_way();           // the page draws meanwhile
  require_one_rate(sampled);  // after the pictures: each log can be seen, and closed, whatever its rate
  auto measured = std::make_shared<View>(LogRequest{&group_, paths, {}}, progress);
  const std::lock_guard lock(lock_);
  view_ = std::move(measured);
}

void Workspace::set_logs(std::vector<std::string> paths) {
  for (std::string& path : paths) path = std::filesystem::absolute(path).lexically_normal().string();
  {
    const std::lock_guard lock(lock_);
    session_.set_logs(std::move(paths));
  }
  open_logs();
}

void Workspace::add_log(const std::string& name, const std::string& content) {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  std::vector<std::string> logs;
  {
    const std::lock_guard lock(lock_);
    logs = session_.logs();
    logs.push_back(session_.store_log(name, content));
  }
  set_logs(std::move(logs));
}

void Workspace::remove_log(std::size_t index) {
  if (jobs_.running()) throw UsageError("a job is still running; cancel it or wait");
  std::vector<std::string> logs;
  {
    const std::lock_guard lock(lock_);
    logs = session_.logs();
  }
  if (index >= logs.size()) throw UsageError("there is no such log");
  logs.erase(logs.begin() + static_cast<std::ptrdiff_t>(index));
  set_logs(std::move(logs));
}

Bytes Workspace::picture(std::size_t log, const std::string& signal, double from_s, double to_s,
                         std::size_t points) const {
  std::shared_ptr<const Trace> trace;
  {
    const std::lock_guard lock(lock_);
    if (log >= traces_.size()) throw UsageError("that log is not open yet");
    trace = traces_[log];
  }
  if (signal != "force" && signal != "position") throw UsageError("signal: force or position");
  const Trace::Picture found =
      trace->picture(signal == "force" ? Trace::Signal::force : Trace::Signal::position, from_s, to_s,
                     std::clamp<std::size_t>(points, 16, 8192));
  std::vector<float> low, high;
  for (const Extremes& point : found.points) {
    low.push_back(point.low);
    high.push_back(point.high);
  }
  Bytes out;
  out.header = {{"first_s", found.first_s},
                {"step_s", found.step_s},
                {"samples_per_point", found.samples_per_point},
                {"start_time_s", trace->start_s()}};
  out.add_f4("low", low);
  out.add_f4("high", high);
  return out;
}

Bytes Workspace::rows() const {
  return view()->rows();
}

Bytes Workspace::model(int version) const {
  return view()->model(View::key_of(version), terms(version));
}

json Workspace::charts(int version, int other) const {
  const Terms second = other != 0 ? terms(other) : Terms{};
  return view()->charts(View::key_of(version), terms(version), View::key_of(other),
                        other != 0 ? &second : nullptr);
}

json Workspace::worth(int version) const {
  return view()->worth(View::key_of(version), terms(version));
}

json Workspace::with_candidate(int version, const std::string& effect) const {
  std::optional<json> found;
  {
    const std::lock_guard lock(lock_);
    found = session_.diagnosis(version);
  }
  if (!found) throw UsageError("this version has not been diagnosed");
  const std::shared_ptr<View> drawn = view();
  const std::optional<Term> term = term_of_card(drawn->measurement(), *found, effect);
  if (!term) throw UsageError(fmt::format("{} is no candidate of this diagnosis", in_quotes(effect)));
  return drawn->with_term(View::key_of(version), terms(version), *term);
}

Terms Workspace::bent_terms(int version, const json& changes) const {
  Terms changed = terms(version);
  apply_changes(changed, changes);
  return changed;
}

json Workspace::adjustable_parameters(int version) const {
  return adjustable(terms(version));
}

Bytes Workspace::bent(int version, const json& changes) const {
  return view()->bent(View::key_of(version), terms(version), bent_terms(version, changes));
}

void Workspace::select(int version) {
  {
    const std::lock_guard lock(lock_);
    session_.select(version);
    if (first_answer_) first_answer_->ended = true;
  }
  events_.tell();
}

void Workspace::undo() {
  {
    const std::lock_guard lock(lock_);
    if (!session_.undo()) throw UsageError("there is nothing to undo");
  }
  events_.tell();
}

void Workspace::redo() {
  {
    const std::lock_guard lock(lock_);
    if (!session_.redo()) throw UsageError("there is nothing to redo");
  }
  events_.tell();
}

void Workspace::set_notes(const std::string& text) {
  const std::lock_guard lock(lock_);
  session_.set_notes(text);
}

std::string Workspace::notes() const {
  const std::lock_guard lock(lock_);
  return session_.notes();
}

}  // namespace slipstack::workbench
