// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "workbench/log/log.h"

namespace slipstack::workbench::test {

/// The text of a recording, read as a log.
inline Log read_recorded(const std::string& text) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) /
                                     ("slipstack_recorded_" + std::to_string(::getpid()) + ".csv");
  std::ofstream(path, std::ios::binary) << text;
  Log log = read_log(path.string());
  std::filesystem::remove(path);
  return log;
}

}  // namespace slipstack::workbench::test
