// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Processes that share the work of one command. All of them make the same calls in the same order; each call
/// ends when all have made it.
class ProcessGroup {
 public:
  virtual ~ProcessGroup() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// What the process `from` says, on all of them.
  virtual std::string broadcast(std::string said, int from) = 0;
  /// What every process says, by rank, on the first; elsewhere nothing.
  virtual std::vector<std::string> gather(std::string said) = 0;
  bool is_first() const { return rank() == 0; }
};

/// One process alone.
class SingleProcess final : public ProcessGroup {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::string broadcast(std::string said, int) override { return said; }
  std::vector<std::string> gather(std::string said) override { return {std::move(said)}; }
};

}  // namespace slipstack::workbench
