// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// Wrong use of a command: printed as one line, exit status 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Files that a command writes: all of them or none. Each is opened beside its place before the work starts,
/// so that a place that cannot be written is an error at once, and takes its name when everything is done.
class Outputs {
 public:
  Outputs() = default;
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;
  ~Outputs();

  /// Claims `path` (empty: none). Throws UsageError when it cannot be written.
  void claim(const std::string& path);
  /// Content of a claimed path.
  void set(const std::string& path, std::string content);
  /// Writes all, then gives them their names. Throws std::runtime_error when the disk is full; then none is
  /// changed.
  void commit();

 private:
  struct File {
    std::filesystem::path path;
    std::filesystem::path temporary;
    std::string content;
  };
  std::vector<File> files_;
};

}  // namespace slipstack::workbench
