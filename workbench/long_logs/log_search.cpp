// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/log_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/nonlinear/filtered_force.h"
#include "workbench/estimate/nonlinear/ringing_band.h"

namespace slipstack::workbench {
namespace {

/// Largest number of extensions of the excerpt; chosen.
constexpr int kMostExtensions = 2;

SharedLogs opened(const LogRequest& request, Progress& progress) {
  const std::vector<std::string>& paths = request.paths;
  for (auto path = paths.begin(); path != paths.end(); ++path) {
    if (std::find(paths.begin(), path, *path) != path) {
      throw UsageError(fmt::format("{}: the log is named twice; name it once", printable(*path)));
    }
  }
  const char* stage = paths.size() == 1 ? "read the log" : "read the logs";
  progress.show(stage);
  return {*request.group, paths, LongLog::kInMemoryBytes,
          [&progress, stage](double fraction) { progress.show(stage, fraction); }, request.in_memory};
}

}  // namespace

LogSearch::LogSearch(const LogRequest& request, Progress& progress)
    : progress_(progress),
      conditioning_(request.conditioning),
      logs_(opened(request, progress)),
      intervals_(searched_intervals(logs_.logs())) {
  measure();
}

LogSearch::LogSearch(const LogSearch& opened, Progress& progress)
    : progress_(progress),
      conditioning_(opened.conditioning_),
      logs_(opened.logs_),
      intervals_(opened.intervals_),
      searched_{std::make_unique<Measurement>(opened.measurement()), opened.searched_.weighing} {
  prepare_whole();
}

void LogSearch::measure() {
  progress_.show("filter the samples");
  searched_ = logs_.measure(intervals_, conditioning_);
  if (conditioning_.bandwidth_Hz == 0.0) {
    if (const auto filter = filter_of_force(measurement())) {
      conditioning_.force_cut_Hz = filter->cut_Hz;
      conditioning_.bandwidth_Hz = std::min(filter->flat_Hz, measurement().bandwidth_Hz());
      searched_ = logs_.measure(intervals_, conditioning_);
    } else if (const auto bandwidth_Hz = bandwidth_of_ringing_Hz(measurement())) {
      conditioning_.bandwidth_Hz = *bandwidth_Hz;
      searched_ = logs_.measure(intervals_, conditioning_);
    }
  }
  prepare_whole();
}

void LogSearch::prepare_whole() {
  const auto show = [this](double fraction) { progress_.show("judge by the whole logs", fraction); };
  whole_.emplace(logs_.logs(), *searched_.measurement, searched_.weighing, logs_.group(), show);
}

Diagnosis LogSearch::diagnose(DiagnoseOptions options) {
  const Terms start = options.start;
  for (;;) {
    check_combination(measurement(), options.baseline);
    check_enough(joined(logs_.paths()), measurement(), options.baseline);
    options.start = terms_on(measurement(), start);
    EffectSearch search(measurement(), options);
    if (measurement().is_excerpt()) {
      options.report("judge by the whole logs", 0.0);
      whole_->judge(search.diagnosis());
    }
    Diagnosis diagnosis = search.conclude();
    if (!extend()) return diagnosis;
  }
}

bool LogSearch::extend() {
  const std::vector<LogInterval> poorly_predicted = whole_->poorly_predicted(intervals_);
  if (poorly_predicted.empty() || extensions_ == kMostExtensions) return false;
  ++extensions_;
  intervals_ = joined(intervals_, poorly_predicted);
  measure();
  return true;
}

}  // namespace slipstack::workbench
