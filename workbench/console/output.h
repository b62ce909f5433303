// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "workbench/base/errors.h"

namespace slipstack::workbench {

/// What a command writes: its files and its text, all of it or nothing. Whether a place can be written is
/// found out before the work starts; files take their names when everything is done, each at once, so that
/// nobody ever reads half of one. A signal that ends the program leaves nothing behind either.
///
/// A place may be `-`, standard output, which then holds the file instead of the text. Pipes and character
/// devices are written to as they are.
class Outputs {
 public:
  /// A file that the command reads: no output may take its place.
  void spare(const std::string& path);
  /// Claims `path` (empty: none). Throws UsageError when it cannot be written, is claimed already, or is an
  /// input.
  void claim(const std::string& path);
  /// Content of a claimed path; nothing happens for an empty one.
  void set(const std::string& path, std::string content);
  /// Writes everything. Throws UsageError when that fails (a full disk): then no file has changed.
  void commit(const std::string& text);

 private:
  enum class Kind { file, stream, standard_output };
  struct Output {
    std::string name;             ///< as the user gave it
    std::filesystem::path place;  ///< symbolic links followed
    std::filesystem::path temporary;
    Kind kind = Kind::file;
    std::string content;
  };
  void write_temporaries() const;
  void write_streams(const std::string& text) const;
  void rename_all() const;

  std::vector<std::string> inputs_;
  std::vector<Output> outputs_;
};

}  // namespace slipstack::workbench
