// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>

#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {

/// A file of the shared measurements; it may not exist.
inline std::filesystem::path shared_file(const char* relative) {
  const char* folder = std::getenv("SLIPSTACK_SHARED");
  const std::filesystem::path root = folder != nullptr
                                         ? std::filesystem::path(folder)
                                         : std::filesystem::path(SLIPSTACK_SOURCE_DIR) / ".." / "shared";
  return root / "data" / relative;
}

/// A log conditioned and weighted as the commands do it.
inline Measurement measured(const std::filesystem::path& path) {
  Measurement measurement(read_log(path));
  weigh_rows(measurement);
  return measurement;
}

}  // namespace slipstack::workbench

#define SKIP_WITHOUT(path)            \
  if (!std::filesystem::exists(path)) \
  GTEST_SKIP() << "SKIP: " << (path) << " is not there; set SLIPSTACK_SHARED"
