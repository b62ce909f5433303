// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/long_logs/processes/process_group.h"

namespace slipstack::workbench {

// The first process of a team decides and asks; the others serve(). Whatever fails anywhere comes to the
// first, so one process tells of it and none is left waiting.

/// Has every process do what `request` says, of which `own` does the first's part, and gives the answers by
/// rank, the first's too. Where a part fails: the first's exception, else InputError (unusable input) or
/// std::runtime_error as the process of lowest rank threw it; all have ended their parts by then.
std::vector<nlohmann::json> ask(ProcessGroup& group, const nlohmann::json& request,
                                const std::function<nlohmann::json()>& own);

/// What the others do: `work` answers each request, until a Dismissal.
void serve(ProcessGroup& group, const std::function<nlohmann::json(const nlohmann::json& request)>& work);

/// Ends serve() on the others at the end of its life. Only on the first, outside ask().
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
