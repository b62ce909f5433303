// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "workbench/base/errors.h"

namespace slipstack::workbench {

/// What a command writes: its files and its text, all of it or nothing. Whether a place can be written is
/// tested before the work starts. The content goes to temporary files that are renamed when everything is
/// done, so that no reader ever sees half of a file; a signal that ends the program leaves no file behind.
///
/// A place may be `-`, standard output, which then receives the file instead of the text. Pipes and character
/// devices are opened and written directly.
class Outputs {
 public:
  /// Declares a file that the command reads: claim() refuses it as an output.
  void protect_input(const std::string& path);
  /// Declares `path` (empty: none) as an output. Throws UsageError when it cannot be written, was claimed
  /// before, or is an input.
  void claim(const std::string& path);
  /// Content of a claimed path; nothing happens for an empty one.
  void set(const std::string& path, std::string content);
  /// Writes everything. Throws UsageError when that fails (a full disk); no file has changed then.
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
