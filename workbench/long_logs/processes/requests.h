// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/long_logs/processes/process_group.h"

namespace slipstack::workbench {

// The first process of a group sends requests; the others serve() them. Every failure is sent to the first,
// so that one process reports it and none is left waiting.

/// Sends `request` to the other processes, does the first process's part by `own`, and returns the answers by
/// rank, its own included. Where a part fails, throws after all parts have ended: the first process's own
/// exception, else the InputError or std::runtime_error of the process of lowest rank.
std::vector<nlohmann::json> ask(ProcessGroup& group, const nlohmann::json& request,
                                const std::function<nlohmann::json()>& own);

/// Called by the other processes: answers each request by `work`, until a Dismissal.
void serve(ProcessGroup& group, const std::function<nlohmann::json(const nlohmann::json& request)>& work);

/// Ends serve() on the other processes when it is destroyed. Only on the first process, outside ask().
class Dismissal {
 public:
  explicit Dismissal(ProcessGroup& group) : group_(group) {}
  ~Dismissal();
  Dismissal(const Dismissal&) = delete;
  Dismissal& operator=(const Dismissal&) = delete;

 private:
  ProcessGroup& group_;
};

}  // namespace slipstack::workbench
