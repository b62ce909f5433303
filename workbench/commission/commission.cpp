// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/commission.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/base/text.h"
#include "workbench/commission/identification.h"
#include "workbench/commission/motions.h"
#include "workbench/commission/prepare.h"
#include "workbench/commission/record_log.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr std::array kPaces{0.4, 1.0};
constexpr double kFollowed = 0.25;   // of the following error's limit: beyond it nothing faster is tried
constexpr double kForceRoom = 0.85;  // of the largest force, at most, in any motion
constexpr double kPlan_s = 25.0;
constexpr double kTrial_s = 16.0;
constexpr double kMostAxis_s = 175.0;  // of the whole, by which a further experiment is left out

/// Runs the stages in their order.
class Commissioning {
 public:
  Commissioning(LiveAxis& axis, CommissionFolder& folder, Progress& progress, bool search_ends)
      : stages_(axis, folder, progress) {
    if (search_ends) stages_.plate.travel_m = 0.0;
  }

  CommissionResult run() {
    axis_ = prepare(stages_);
    logs_.push_back(axis_.travel_log);
    for (std::size_t i = 0; i < kPaces.size(); ++i) {
      if (!look(i)) break;
    }
    const json found = diagnosis();
    CommissionResult result;
    result.trials = try_models(stages_, axis_, found.at("models"));
    finish(result, found);
    return result;
  }

 private:
  double force_limit_N() const { return stages_.plate.force_limit_N(); }

  /// False: this motion or the next one is too much for the axis.
  bool look(std::size_t i) {
    const std::string name = fmt::format("look_{}", i + 1);
    const json& found = stages_.stage(name, 0.2 + 0.08 * static_cast<double>(i), [&] { return looked(i); });
    if (!found.contains("log")) {
      const std::string why = found.at("skipped").get<std::string>();
      stages_.report(name, "left out");
      stages_.notes.push_back(
          fmt::format("Motions at {:.0f} % of the limits were left out: {}.", 100.0 * kPaces[i], why));
      return false;
    }
    seen_force_N_ = found.at("force_N").get<double>();
    seen_error_m_ = found.at("error_m").get<double>();
    logs_.push_back(stages_.folder.path(found.at("log").get<std::string>()));
    stages_.report(name, fmt::format("{:.0f} % of the limits: {:.3g} N, {:.3g} µm behind at most",
                                     100.0 * kPaces[i], seen_force_N_, 1e6 * seen_error_m_));
    return true;
  }

  json looked(std::size_t i) {
    const std::string why_not = i == 0 ? "" : too_much();
    if (!why_not.empty()) return {{"skipped", why_not}};
    const AxisRecord record = stages_.follow(
        first_look(axis_.limits, kPaces[i], stages_.plate.encoder_resolution_m), approach_mps(axis_.limits),
        fmt::format("motions at {:.0f} % of the limits", 100.0 * kPaces[i]));
    const std::string log = fmt::format("look_{}.csv", i + 1);
    stages_.folder.write(log, log_csv(record, stages_.plate));
    return {{"log", log}, {"force_N", largest(record.force_N)}, {"error_m", largest(record.error_m)}};
  }

  /// Why the faster motions are not tried; else empty.
  std::string too_much() const {
    // The inertial part grows with the square of the pace.
    const double inertial_N = std::max(0.0, seen_force_N_ - axis_.friction_N);
    const double growth = squared(kPaces[1] / kPaces[0]);
    if (seen_force_N_ + (growth - 1.0) * inertial_N > kForceRoom * force_limit_N()) {
      return fmt::format("those before took {:.3g} N of the largest force of {:.3g} N", seen_force_N_,
                         force_limit_N());
    }
    if (seen_error_m_ > kFollowed * axis_.settings.following_error_m)
      return fmt::format("with those before the axis was {:.2f} mm behind", 1e3 * seen_error_m_);
    return "";
  }

  json diagnosis() {
    const json& first = stages_.stage(
        "diagnosis_1", 0.45, [&] { return identify(logs_, "model_1", stages_.folder, stages_.progress); });
    report_diagnosis("diagnosis_1", first);
    if (first.at("question").is_null()) return first;
    if (!planned(first.at("question"), first.at("models").size() + 2)) return first;
    json second = stages_.stage("diagnosis_2", 0.62,
                                [&] { return identify(logs_, "model_2", stages_.folder, stages_.progress); });
    report_diagnosis("diagnosis_2", second);
    return second;
  }

  void report_diagnosis(const std::string& name, const json& found) {
    std::string text = found.at("verdict").get<std::string>();
    std::replace(text.begin(), text.end(), '_', ' ');
    std::vector<std::string> effects;
    for (const json& model : found.at("models")) {
      effects.push_back(model.at("effect").get<std::string>());
    }
    std::erase(effects, "");
    stages_.report(name, effects.empty() ? text : text + ": " + joined(effects));
  }

  /// True where a further log came of it. `trials`: as many as are expected after it.
  bool planned(const json& question, std::size_t trials) {
    const json& found = stages_.stage("planned", 0.55, [&] { return experiment(question, trials); });
    const bool done = found.contains("log");
    stages_.report("planned",
                   done ? question.at("reason").get<std::string>() : found.at("skipped").get<std::string>());
    if (done) logs_.push_back(stages_.folder.path(found.at("log").get<std::string>()));
    return done;
  }

  json experiment(const json& question, std::size_t trials) {
    if (stages_.used_s() + kPlan_s + kTrial_s * static_cast<double>(trials) > kMostAxis_s)
      return {{"skipped", "left out: the axis would be used for more than three minutes"}};
    const auto motion = planned_motion(logs_, question.at("effects").get<std::vector<std::string>>(),
                                       axis_.limits, kPlan_s, stages_.progress);
    if (!motion) return {{"skipped", "left out: within the room of the axis it would say no more"}};
    if (motion->peak_force_N > kForceRoom * force_limit_N())
      return {{"skipped", "left out: it would take nearly all of the force"}};
    const AxisRecord record =
        stages_.follow(motion->motion, approach_mps(axis_.limits), "the planned experiment");
    stages_.folder.write("planned.csv", log_csv(record, stages_.plate));
    return {{"log", "planned.csv"}};
  }

  void finish(CommissionResult& result, const json& found) {
    for (std::size_t i = 0; i < result.trials.size(); ++i) {
      const ModelTrial& trial = result.trials[i];
      if (trial.kept) result.deployed = i;
      stages_.report(fmt::format("try_{}", i), trial.added + (trial.kept ? "" : ": taken back"));
      if (trial.limited_share > 0.01) {
        stages_.notes.push_back(
            fmt::format("With {} the force was at its limit for {:.0f} % of the test; what is missing there "
                        "no model can give.",
                        trial.added, 100.0 * trial.limited_share));
      }
    }
    const ModelTrial& deployed = result.trials[result.deployed];
    stages_.stage("deployed", 0.99, [&]() -> json {
      if (!deployed.file.empty()) stages_.folder.write("deployed.toml", stages_.folder.read(deployed.file));
      return {{"model", deployed.file}};
    });
    const std::string unexplained = found.at("unexplained").get<std::string>();
    if (!unexplained.empty())
      stages_.notes.push_back(fmt::format("Something is left that no effect explains: {}.", unexplained));
    // A folder of an earlier version has none.
    for (const json& limit : found.value("detection_limits", json::array()))
      stages_.notes.push_back(limit.get<std::string>());
    const std::string stored = stages_.axis.keep();
    if (!stored.empty()) {
      stages_.stage("stored", 0.995, []() -> json { return json::object(); });
      stages_.report("stored", stored);
    }
    result.verdict = found.at("verdict").get<std::string>();
    result.mass_kg = axis_.mass_kg;
    result.axis_s = stages_.used_s();
    result.stages = stages_.reports;
    result.notes = stages_.notes;
    stages_.axis.switch_off();
  }

  Stages stages_;
  PreparedAxis axis_;
  double seen_force_N_ = 0.0;
  double seen_error_m_ = 0.0;
  std::vector<std::string> logs_;
};

}  // namespace

CommissionResult commission(LiveAxis& axis, CommissionFolder& folder, Progress& progress, bool search_ends) {
  try {
    return Commissioning(axis, folder, progress, search_ends).run();
  } catch (...) {
    const std::exception_ptr why = std::current_exception();
    try {
      axis.switch_off();
      axis.give_back();
    } catch (const DriveLost&) {  // the first reason counts
    }
    std::rethrow_exception(why);
  }
}

}  // namespace slipstack::workbench
