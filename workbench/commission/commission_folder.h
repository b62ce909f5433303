// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace slipstack::workbench {

/// A commissioning as a folder of plain files: what each finished stage found (stages.json), logs, models. A
/// file is there whole or not at all, also after a power cut: it is written beside its place, forced to the
/// disk and renamed. Opened again, the folder tells which stages are done.
class CommissionFolder {
 public:
  /// Creates the folder or takes up what is in it. `axis`: what tells this axis from others. Throws
  /// UsageError where the folder belongs to another one, is none of a commissioning, or cannot be written.
  CommissionFolder(const std::filesystem::path& folder, const std::string& axis);

  bool done(const std::string& stage) const { return stages_.at("stages").contains(stage); }
  const nlohmann::json& found(const std::string& stage) const { return stages_.at("stages").at(stage); }
  /// An object; what it names (logs, models) has to be written before.
  void finish(const std::string& stage, nlohmann::json found);
  /// The folder held a commissioning when it was opened.
  bool resumed() const { return resumed_; }

  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  /// Throws UsageError where that cannot be done.
  void write(const std::string& name, const std::string& content) const;
  /// Throws UsageError where it is missing.
  std::string read(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  nlohmann::json stages_;
  bool resumed_ = false;
};

}  // namespace slipstack::workbench
