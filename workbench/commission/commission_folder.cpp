// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/commission_folder.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <utility>

#include "workbench/base/atomic_write.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kStages = "stages.json";
constexpr int kFormat = 1;

}  // namespace

CommissionFolder::CommissionFolder(const std::filesystem::path& folder, const std::string& axis)
    : folder_(folder) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    throw UsageError(fmt::format("{}: no folder can be made there ({}); name another with --out",
                                 printable(folder_.string()), error.message()));
  }
  stages_ = {{"format", kFormat}, {"axis", axis}, {"stages", nlohmann::json::object()}};
  std::ifstream file(path(kStages));
  if (!file) {
    if (!std::filesystem::is_empty(folder_, error) || error) {
      throw UsageError(
          fmt::format("{}: holds other files and no commissioning; name an empty or a new folder with --out",
                      printable(folder_.string())));
    }
    write(kStages, stages_.dump(2) + "\n");
    return;
  }
  const nlohmann::json before = nlohmann::json::parse(file, nullptr, false);
  const bool whole = before.is_object() && before.contains("format") && before["format"] == kFormat &&
                     before.contains("axis") && before["axis"].is_string() && before.contains("stages") &&
                     before["stages"].is_object();
  if (!whole) {
    throw UsageError(fmt::format("{}: is not the record of a commissioning; name another folder with --out",
                                 printable(path(kStages).string())));
  }
  if (before["axis"] != axis) {
    throw UsageError(fmt::format("{}: is of another axis ({}); name another folder with --out",
                                 printable(folder_.string()), printable(before["axis"].get<std::string>())));
  }
  stages_ = before;
  resumed_ = true;
}

void CommissionFolder::finish(const std::string& stage, nlohmann::json found) {
  stages_["stages"][stage] = std::move(found);
  write(kStages, stages_.dump(2) + "\n");
}

void CommissionFolder::write(const std::string& name, const std::string& content) const {
  write_atomically(path(name), content);
}

std::string CommissionFolder::read(const std::string& name) const {
  std::ifstream file(path(name), std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    throw UsageError(fmt::format("{}: is missing; begin anew in another folder with --out",
                                 printable(path(name).string())));
  }
  return content;
}

}  // namespace slipstack::workbench
