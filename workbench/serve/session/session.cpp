// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "workbench/base/atomic_write.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/report/json_values.h"
#include "workbench/serve/session/plain_file.h"

namespace slipstack::workbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostBytes = std::size_t{64} << 20;  // of session.json, a diagnosis or the notes
constexpr const char* kFormat = "slipstack session 1";

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw UsageError(fmt::format("{}: {}", printable(path.string()), error.message()));
}

json version_json(const Version& version) {
  return {{"id", version.id},           {"parent", version.parent},   {"what", version.what},
          {"date", version.date},       {"file", version.file},       {"before_N", version.before_N},
          {"after_N", version.after_N}, {"floor_N", version.floor_N}, {"effects", version.effects}};
}

Version version_of(const json& entry) {
  return {entry.at("id"),      entry.at("parent"),  entry.at("what"),
          entry.at("date"),    entry.at("file"),    entry.at("before_N"),
          entry.at("after_N"), entry.at("floor_N"), entry.at("effects")};
}

/// "3.toml" -> 3; 0 for other names.
int number_of_file(const fs::path& path) {
  const std::string stem = path.stem().string();
  if (stem.empty() || stem.size() > 6 || stem.find_first_not_of("0123456789") != std::string::npos) return 0;
  return std::stoi(stem);
}

void take(Version& version, const Model& model) {
  version.effects = ids_of(model.terms);
  version.after_N = model.source.holdout_rmse_N;
  version.floor_N = model.source.noise_floor_N;
  if (!model.history.empty()) version.date = model.history.back().date;
}

}  // namespace

Session::Session(const fs::path& folder) : folder_(fs::absolute(folder).lexically_normal()) {
  for (const char* part : {"logs", "models", "diagnoses"}) make_folder(folder_ / part);
  if (fs::exists(folder_ / "session.json")) load();
  adopt_models();
  save();
}

void Session::load() {
  const fs::path path = folder_ / "session.json";
  try {
    const json data = json::parse(read_whole(path, kMostBytes));
    if (data.at("format") != kFormat) throw InputError("another format");
    for (const json& log : data.at("logs")) {
      const fs::path named = log.get<std::string>();
      logs_.push_back((named.is_absolute() ? named : folder_ / named).string());
    }
    for (const json& entry : data.at("versions")) {
      Version version = version_of(entry);
      // A list from elsewhere must not lead out of the folder.
      if (version.id <= 0 || !lies_in(folder_, folder_ / version.file)) throw InputError("a file outside it");
      if (fs::exists(folder_ / version.file)) versions_.push_back(std::move(version));
    }
    current_ = data.at("current");
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: not the list of a session ({}); move it away, the models stay",
                                 printable(path.string()), printable(error.what())));
  }
  if (find(current_) == nullptr) current_ = versions_.empty() ? 0 : versions_.back().id;
}

void Session::adopt_models() {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / "models")) {
    const std::string file = "models/" + entry.path().filename().string();
    const bool known = std::any_of(versions_.begin(), versions_.end(),
                                   [&](const Version& version) { return version.file == file; });
    if (!known && entry.path().extension() == ".toml" && entry.path().filename().string()[0] != '.') {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  for (const fs::path& path : found) {
    Version version;
    const int number = number_of_file(path);
    version.id = number > 0 && find(number) == nullptr ? number : next_id();
    version.what = fmt::format("{} from the folder", printable(path.filename().string()));
    version.file = "models/" + path.filename().string();
    take(version, read_model(path));
    versions_.push_back(std::move(version));
    if (current_ == 0) current_ = versions_.back().id;
  }
}

int Session::next_id() const {
  int last = 0;
  for (const Version& version : versions_) last = std::max({last, version.id, number_of_file(version.file)});
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_ / "models", error)) {
    last = std::max(last, number_of_file(entry.path()));
  }
  return last + 1;
}

void Session::save() const {
  json logs = json::array();
  for (const std::string& log : logs_) {
    logs.push_back(lies_in(folder_, log) ? fs::path(log).lexically_relative(folder_).string() : log);
  }
  json versions = json::array();
  for (const Version& version : versions_) versions.push_back(version_json(version));
  const json data{{"format", kFormat}, {"logs", logs}, {"current", current_}, {"versions", versions}};
  write_atomically(folder_ / "session.json", own_json_text(data));
}

void Session::set_logs(std::vector<std::string> logs) {
  std::vector<std::string> before = std::exchange(logs_, std::move(logs));
  try {
    save();
  } catch (...) {
    logs_ = std::move(before);
    throw;
  }
}

std::string Session::store_log(const std::string& name, const std::string& content) const {
  const fs::path plain = plain_name(name, "log.csv");
  fs::path path = folder_ / "logs" / plain;
  for (int number = 2; fs::exists(path); ++number) {
    path =
        folder_ / "logs" / fmt::format("{}-{}{}", plain.stem().string(), number, plain.extension().string());
  }
  write_atomically(path, content);
  return path.string();
}

const Version* Session::find(int id) const {
  const auto found =
      std::find_if(versions_.begin(), versions_.end(), [id](const Version& one) { return one.id == id; });
  return found == versions_.end() ? nullptr : &*found;
}

const Version& Session::version(int id) const {
  if (const Version* found = find(id)) return *found;
  throw UsageError(fmt::format("there is no version {} in this session", id));
}

Model Session::model(int id) const {
  return read_model(model_path(id));
}

int Session::add(int parent, const std::string& what, const Model& model, double before_N) {
  Version version;
  version.id = next_id();
  version.parent = parent;
  version.what = what;
  version.file = fmt::format("models/{}.toml", version.id);
  version.before_N = before_N;
  take(version, model);
  write_atomically(folder_ / version.file, to_toml(model));
  versions_.push_back(version);
  const int before = std::exchange(current_, version.id);
  try {
    save();
  } catch (...) {
    versions_.pop_back();
    current_ = before;
    throw;
  }
  return version.id;
}

void Session::select(int id) {
  const int before = std::exchange(current_, version(id).id);
  try {
    save();
  } catch (...) {
    current_ = before;
    throw;
  }
}

int Session::undo_to() const {
  const Version* now = current();
  return now != nullptr && find(now->parent) != nullptr ? now->parent : 0;
}

int Session::redo_to() const {
  int latest = 0;
  for (const Version& version : versions_) {
    if (current_ != 0 && version.parent == current_) latest = std::max(latest, version.id);
  }
  return latest;
}

bool Session::undo() {
  if (undo_to() == 0) return false;
  select(undo_to());
  return true;
}

bool Session::redo() {
  if (redo_to() == 0) return false;
  select(redo_to());
  return true;
}

std::optional<json> Session::diagnosis(int id) const {
  const fs::path path = folder_ / "diagnoses" / fmt::format("{}.json", id);
  if (!fs::exists(path)) return std::nullopt;
  try {
    return json::parse(read_whole(path, kMostBytes));
  } catch (const std::exception&) {
    return std::nullopt;  // of another version, or damaged: it can be made again
  }
}

void Session::set_diagnosis(int id, const json& diagnosis) const {
  write_atomically(folder_ / "diagnoses" / fmt::format("{}.json", id), own_json_text(diagnosis));
}

std::string Session::notes() const {
  const fs::path path = folder_ / "notes.md";
  return fs::exists(path) ? read_whole(path, kMostBytes) : "";
}

void Session::set_notes(const std::string& text) const {
  write_atomically(folder_ / "notes.md", text);
}

json Session::to_json() const {
  json versions = json::array();
  for (const Version& version : versions_) versions.push_back(version_json(version));
  return {{"folder", printable(folder_.string())},
          {"versions", versions},
          {"current", current_},
          {"undo_to", undo_to()},
          {"redo_to", redo_to()}};
}

}  // namespace slipstack::workbench
