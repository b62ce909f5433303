// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/shared_logs.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/parallel.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/long_logs/log_sums.h"
#include "workbench/long_logs/processes/requests.h"
#include "workbench/long_logs/whole_logs.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// The logs that a process has opened before the surveys are exchanged.
struct Opened {
  std::vector<std::optional<LongLog>> logs;    ///< empty: read by another process, or unusable
  std::map<std::size_t, std::string> faults;   ///< by log
  std::map<std::size_t, std::string> surveys;  ///< by log, of those surveyed here that stay in their files
};

/// Opens the logs that fit into memory, and this process's share of the others.
Opened open_share(const ProcessGroup& group, const std::vector<std::string>& paths,
                  std::size_t in_memory_bytes, const SharedLogs::Progress& progress,
                  const LogsInMemory& in_memory) {
  const auto members = static_cast<std::size_t>(group.size());
  const auto rank = static_cast<std::size_t>(group.rank());
  Opened opened;
  opened.logs.resize(paths.size());
  std::vector<std::string> faults(paths.size());
  std::atomic<std::size_t> done{0};
  parallel_for(paths.size(), [&](std::size_t i) {
    try {
      if (const auto held = in_memory.find(paths[i]); held != in_memory.end()) {
        opened.logs[i] = LongLog::held(held->second);
        return;
      }
      const bool left_to_others = i % members != rank && LongLog::stays_in_file(paths[i], in_memory_bytes);
      if (!left_to_others) opened.logs[i] = LongLog::open(paths[i], in_memory_bytes);
    } catch (const InputError& error) {
      faults[i] = error.what();
    }
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(paths.size()));
  });
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (!faults[i].empty()) opened.faults[i] = faults[i];
    if (members > 1 && opened.logs[i] && opened.logs[i]->survey() != nullptr) {
      opened.surveys[i] = to_bytes(*opened.logs[i]->survey());
    }
  }
  return opened;
}

json binary_of(const std::string& bytes) {
  return json::binary(std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
}

/// What one process sends to the others: faults and surveys.
json described(const Opened& opened) {
  json faults = json::array();
  for (const auto& [log, fault] : opened.faults) faults.push_back({log, fault});
  json surveys = json::array();
  for (const auto& [log, survey] : opened.surveys) surveys.push_back({log, binary_of(survey)});
  return {{"faults", faults}, {"surveys", surveys}};
}

/// Opens the logs that other processes have surveyed.
std::vector<LongLog> complete(Opened opened, const std::vector<std::string>& paths, const json& surveys) {
  for (const json& one : surveys) {
    const auto log = one[0].get<std::size_t>();
    if (opened.logs[log]) continue;
    const auto& bytes = one[1].get_binary();
    opened.logs[log] = LongLog::open(paths[log], survey_of({bytes.begin(), bytes.end()}));
  }
  std::vector<LongLog> logs;
  logs.reserve(paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (!opened.logs[i]) {
      throw InputError(paths[i] + ": is not the same file for every process; give one that all of them see");
    }
    logs.push_back(std::move(*opened.logs[i]));
  }
  return logs;
}

json to_json(const ConditioningOptions& options) {
  return {{"bandwidth_Hz", options.bandwidth_Hz},
          {"force_cut_Hz", options.force_cut_Hz},
          {"maximum_rows", options.maximum_rows},
          {"per_log", options.per_log},
          {"force_noise_N", options.force_noise_N}};
}

ConditioningOptions conditioning_of(const json& value) {
  ConditioningOptions options;
  options.bandwidth_Hz = value.at("bandwidth_Hz").get<double>();
  options.force_cut_Hz = value.at("force_cut_Hz").get<double>();
  options.maximum_rows = value.at("maximum_rows").get<std::size_t>();
  options.per_log = value.at("per_log").get<std::vector<std::string>>();
  options.force_noise_N = value.at("force_noise_N").get<double>();
  return options;
}

Searched measured(const std::vector<LongLog>& logs, const std::vector<LogInterval>& intervals,
                  const ConditioningOptions& conditioning) {
  Searched searched;
  searched.measurement = std::make_unique<Measurement>(chunks_of(logs, intervals), conditioning);
  refuse_slow_or_short(*searched.measurement);
  searched.weighing = weigh_rows(*searched.measurement);
  return searched;
}

/// The state of a serving process between requests, and its answers.
class Worker {
 public:
  explicit Worker(ProcessGroup& group) : group_(group) {}

  json work(const json& request) {
    const auto what = request.at("do").get<std::string>();
    if (what == "open") {
      paths_ = request.at("paths").get<std::vector<std::string>>();
      opened_ = open_share(group_, paths_, request.at("in_memory_bytes").get<std::size_t>(), {}, {});
      return described(opened_);
    }
    if (what == "complete") {
      logs_ = complete(std::move(opened_), paths_, request.at("surveys"));
      return nullptr;
    }
    if (what == "measure") {
      std::vector<LogInterval> intervals;
      for (const json& one : request.at("intervals")) {
        intervals.push_back(
            {one[0].get<std::size_t>(), one[1].get<std::size_t>(), one[2].get<std::size_t>()});
      }
      searched_ = measured(logs_, intervals, conditioning_of(request.at("conditioning")));
      return nullptr;
    }
    if (what == "sum") {
      return LogSums(logs_, *searched_.measurement, searched_.weighing, group_).share(request);
    }
    throw std::logic_error("unknown request to a process: " + what);
  }

 private:
  ProcessGroup& group_;
  std::vector<std::string> paths_;
  Opened opened_;
  std::vector<LongLog> logs_;
  Searched searched_;
};

}  // namespace

SharedLogs::SharedLogs(ProcessGroup& group, const std::vector<std::string>& paths,
                       std::size_t in_memory_bytes, const Progress& progress, const LogsInMemory& in_memory)
    : group_(group), paths_(paths) {
  if (group.size() > 1 && !in_memory.empty()) {
    throw std::logic_error("logs in memory are not there for other processes");
  }
  const std::size_t of_each = in_memory_bytes / std::max<std::size_t>(1, paths.size());
  Opened own;
  const auto answers = ask(group, {{"do", "open"}, {"paths", paths}, {"in_memory_bytes", of_each}}, [&] {
    own = open_share(group, paths, of_each, progress, in_memory);
    return described(own);
  });
  std::map<std::size_t, std::string> faults;
  json surveys = json::array();
  for (const json& answer : answers) {
    for (const json& one : answer["faults"])
      faults.try_emplace(one[0].get<std::size_t>(), one[1].get<std::string>());
    for (const json& one : answer["surveys"]) surveys.push_back(one);
  }
  if (!faults.empty()) throw InputError(faults.begin()->second);
  ask(group, {{"do", "complete"}, {"surveys", surveys}}, [&] {
    logs_ = complete(std::move(own), paths, surveys);
    return nullptr;
  });
}

Searched SharedLogs::measure(const std::vector<LogInterval>& intervals,
                             const ConditioningOptions& conditioning) const {
  std::size_t all = 0;
  std::size_t searched = 0;
  for (const LongLog& log : logs_) all += log.sample_count();
  for (const LogInterval& one : intervals) searched += one.count;
  if (searched == all) return measured(logs_, intervals, conditioning);
  json list = json::array();
  for (const LogInterval& one : intervals) list.push_back({one.log, one.first, one.count});
  Searched result;
  ask(group_, {{"do", "measure"}, {"intervals", list}, {"conditioning", to_json(conditioning)}}, [&] {
    result = measured(logs_, intervals, conditioning);
    return nullptr;
  });
  return result;
}

void serve_logs(ProcessGroup& group) {
  Worker worker(group);
  serve(group, [&](const json& request) { return worker.work(request); });
}

}  // namespace slipstack::workbench
