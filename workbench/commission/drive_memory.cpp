// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/drive_memory.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kBefore = "drive_before.json";

}  // namespace

DriveMemory memory_in(CommissionFolder& folder) {
  return {std::filesystem::exists(folder.path(kBefore)) ? folder.read(kBefore) : std::string(),
          [&folder](const std::string& text) { folder.write(kBefore, text); }, folder.done("mass")};
}

}  // namespace slipstack::workbench
