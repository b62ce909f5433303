// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workbench/loop/comparison/measures.h"

namespace slipstack::workbench {

/// What a comparison has measured so far, in a file: one line of JSON for each axis, added as soon as the
/// axis is done, so that a comparison that was stopped goes on behind it. A last line that was cut off is
/// dropped.
class ComparisonFile {
 public:
  /// Nothing is kept.
  ComparisonFile() = default;
  /// `task`: what determines the measures beside seed and contender. Throws UsageError where the file is that
  /// of another task or cannot be written, InputError where it is no such file.
  ComparisonFile(std::string path, std::string task);

  /// The measures of these contenders on the axis of this seed; none where not all of them are there.
  std::optional<std::vector<Measures>> find(std::uint64_t seed,
                                            const std::vector<ContenderName>& contenders) const;
  /// Throws UsageError when it cannot be written.
  void add(std::uint64_t seed, const std::vector<ContenderName>& contenders,
           const std::vector<Measures>& measures);

 private:
  void read();

  std::string path_;
  std::string task_;
  std::map<std::uint64_t, std::map<std::string, Measures>> axes_;
};

}  // namespace slipstack::workbench
