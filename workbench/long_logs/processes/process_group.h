// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Processes that share the work of one command. All of them make the same calls in the same order; a call
/// returns when all have made it.
class ProcessGroup {
 public:
  virtual ~ProcessGroup() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Returns the message of the process `from` on all processes.
  virtual std::string broadcast(std::string message, int from) = 0;
  /// Returns the messages of all processes, by rank, on the first; nothing on the others.
  virtual std::vector<std::string> gather(std::string message) = 0;
  bool is_first() const { return rank() == 0; }
};

/// One process alone.
class SingleProcess final : public ProcessGroup {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::string broadcast(std::string message, int) override { return message; }
  std::vector<std::string> gather(std::string message) override { return {std::move(message)}; }
};

}  // namespace slipstack::workbench
