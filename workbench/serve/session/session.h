// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/model/model.h"

namespace slipstack::workbench {

/// One model of the history, and how it came from another: fitted, an effect added or removed, set by hand.
struct Version {
  int id = 0;
  int parent = 0;         ///< id; 0: from nothing
  std::string what;       ///< "viscous added"
  std::string date;       ///< UTC, ISO 8601
  std::string file;       ///< within the folder: "models/3.toml"
  double before_N = 0.0;  ///< held-out error of the model before; 0: there was none
  double after_N = 0.0;   ///< held-out error
  double floor_N = 0.0;
  std::vector<std::string> effects;
};

/// A session: a folder of plain files, which the command line reads and writes too.
///
///   session.json     the logs, the history and where in it the work stands
///   logs/            logs that were uploaded, converted or recorded; others stay where they are
///   models/N.toml    one model file for each version, as `slipstack fit` and `add` write them
///   diagnoses/N.json what was found to be missing in version N
///   notes.md         the user's own words
///
/// Every file is written whole (base/atomic_write.h), models before the list that names them: a crash at
/// any moment leaves a session that opens. A model file that is not in the list, put there by the command
/// line, joins the history as a version from nothing.
class Session {
 public:
  /// Opens the session in `folder`, or makes one. Throws UsageError and InputError.
  explicit Session(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  /// Logs as absolute paths, in order.
  const std::vector<std::string>& logs() const { return logs_; }
  void set_logs(std::vector<std::string> logs);
  /// Stores a log of this name in the folder and returns its path; a name that is taken gets a number.
  std::string store_log(const std::string& name, const std::string& content) const;

  const std::vector<Version>& versions() const { return versions_; }
  /// The version at which the work stands; nullptr before the first.
  const Version* current() const { return find(current_); }
  const Version* find(int id) const;
  /// Throws UsageError for an id that is none.
  const Version& version(int id) const;
  Model model(int id) const;
  std::filesystem::path model_path(int id) const { return folder_ / version(id).file; }
  /// Adds a version after `parent` (0: from nothing) and goes there. Returns its id.
  int add(int parent, const std::string& what, const Model& model, double before_N);
  void select(int id);
  /// One version back, and forward again to where the work came from. False where there is none.
  bool undo();
  bool redo();
  int undo_to() const;
  int redo_to() const;

  std::optional<nlohmann::json> diagnosis(int id) const;
  void set_diagnosis(int id, const nlohmann::json& diagnosis) const;
  std::string notes() const;
  void set_notes(const std::string& text) const;

  /// What the page shows of it.
  nlohmann::json to_json() const;

 private:
  void load();
  void adopt_models();
  void save() const;
  int next_id() const;

  std::filesystem::path folder_;
  std::vector<std::string> logs_;
  std::vector<Version> versions_;
  int current_ = 0;
};

}  // namespace slipstack::workbench
