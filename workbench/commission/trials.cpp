// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/commission/motions.h"
#include "workbench/commission/record_log.h"
#include "workbench/estimate/linear/linearisation.h"
#include "workbench/log/log.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr double kStandardErrors = 3.0;
constexpr const char* kTestLog = "test.csv";

/// The terms of a trial, as identified and as the controller runs them.
struct TrialTerms {
  Terms identified;
  Terms on_target;
};

Terms masses_of(const Terms& terms) {
  Terms kept;
  std::copy_if(terms.begin(), terms.end(), std::back_inserter(kept), is_mass);
  return kept;
}

/// The drive refused the model before the axis moved, or the axis left its reference with it.
bool may_be_the_model(const AxisRecord& record) {
  return record.position_m.empty() || record.lost_hold;
}

class ModelTrials {
 public:
  ModelTrials(Stages& stages, const PreparedAxis& axis, const json& models)
      : stages_(stages), axis_(axis), test_(tracking_test(axis.limits)) {
    ModelTrial mass_alone;
    mass_alone.added = "mass alone";
    mass_alone.kept = true;
    trials_.push_back(mass_alone);
    for (const json& model : models) {
      ModelTrial trial;
      trial.added = model.at("added").get<std::string>();
      trial.effect = model.at("effect").get<std::string>();
      trial.file = model.at("file").get<std::string>();
      trials_.push_back(trial);
    }
  }

  std::vector<ModelTrial> run() {
    for (std::size_t i = 0; i < trials_.size(); ++i) {
      take(i);
      trials_[i].prediction_rms_N = prediction_rms_N(terms_of(trials_[i]).identified);
      if (i > 0) judge(i);
    }
    // What a resumed commissioning has tried before is not on the axis yet.
    deploy(trials_[kept_]);
    return trials_;
  }

 private:
  TrialTerms terms_of(const ModelTrial& trial) const {
    if (!trial.file.empty()) {
      const Model model = read_controller_model(stages_.folder.path(trial.file));
      return {model.terms, model.target_terms};
    }
    const Terms mass = masses_of(read_controller_model(stages_.folder.path(trials_[1].file)).terms);
    return {mass, mass};
  }

  std::string deploy(const ModelTrial& trial) {
    return stages_.axis.deploy(axis_.settings, terms_of(trial).on_target);
  }

  void take(std::size_t i) {
    ModelTrial& trial = trials_[i];
    const double fraction = 0.7 + 0.28 * static_cast<double>(i) / static_cast<double>(trials_.size());
    const std::string name = fmt::format("try_{}", i);
    const json& found = stages_.stage(name, fraction, [&] { return tried(i); });
    if (found.at("added") != trial.added)
      throw CommissionStopped("the folder's trials are not of its models; begin anew in another folder");
    trial.rms_m = found.at("rms_m").get<std::vector<double>>();
    trial.reversal_rms_m = found.at("reversal_rms_m").get<std::vector<double>>();
    trial.limited_share = found.at("limited_share").get<double>();
    trial.fault = found.at("fault").get<std::string>();
  }

  json tried(std::size_t i) {
    AxisRecord record;
    record.fault = deploy(trials_[i]);
    if (record.fault.empty()) record = stages_.run(test_.motion, approach_mps(axis_.limits));
    CycleErrors error;
    const double cycle_s = static_cast<double>(test_.cycle_points) / test_.motion.rate_Hz;
    if (record.fault.empty()) error = cycle_errors(record, cycle_s);
    // Whatever comes next, what makes the axis worse does not stay.
    if (i > 0 && !is_lower(error.rms_m, trials_[kept_].rms_m)) deploy(trials_[kept_]);
    if (!record.fault.empty() && (i == 0 || !may_be_the_model(record)))
      throw CommissionStopped("the tracking test: " + record.fault);
    if (i == 0) stages_.folder.write(kTestLog, log_csv(record, stages_.plate));
    return {{"added", trials_[i].added},
            {"rms_m", error.rms_m},
            {"reversal_rms_m", error.reversal_rms_m},
            {"limited_share", record.limited_share},
            {"fault", record.fault}};
  }

  double prediction_rms_N(const Terms& terms) const {
    const Measurement measurement(read_log(stages_.folder.path(kTestLog)));
    return measurement.weighted_rms(residual_of(measurement, terms));
  }

  void judge(std::size_t i) {
    ModelTrial& trial = trials_[i];
    trial.kept = is_lower(trial.rms_m, trials_[kept_].rms_m);
    if (trial.kept) {
      kept_ = i;
    } else if (!trial.fault.empty()) {
      stages_.notes.push_back(fmt::format("With {}: {}. It was taken back.", trial.added, trial.fault));
    } else {
      const Spread now = spread_of(trial.rms_m);
      const Spread before = spread_of(trials_[kept_].rms_m);
      stages_.notes.push_back(
          fmt::format("{} was taken back: the axis follows to {:.4g} µm with it and to {:.4g} µm without, "
                      "which is not less beyond the spread ({:.2g} µm).",
                      trial.added, 1e6 * now.mean, 1e6 * before.mean,
                      1e6 * std::hypot(now.standard_error, before.standard_error)));
    }
  }

  Stages& stages_;
  const PreparedAxis& axis_;
  TrackingTest test_;
  std::vector<ModelTrial> trials_;
  std::size_t kept_ = 0;
};

}  // namespace

Spread spread_of(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  Spread spread;
  for (const double value : values) spread.mean += value / count;
  if (values.size() < 2) return spread;
  double squares = 0.0;
  for (const double value : values) squares += squared(value - spread.mean);
  spread.standard_error = std::sqrt(squares / (count - 1.0) / count);
  return spread;
}

bool is_lower(const std::vector<double>& after, const std::vector<double>& before) {
  if (after.empty() || before.empty()) return false;
  const Spread a = spread_of(after);
  const Spread b = spread_of(before);
  return b.mean - a.mean > kStandardErrors * std::hypot(a.standard_error, b.standard_error);
}

std::vector<ModelTrial> try_models(Stages& stages, const PreparedAxis& axis, const json& models) {
  return ModelTrials(stages, axis, models).run();
}

}  // namespace slipstack::workbench
