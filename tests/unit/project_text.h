// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace slipstack {

/// The text of a file of the project, for tests that compare what several files say. SLIPSTACK_SOURCE_DIR is
/// defined for the test.
inline std::string project_text(const std::string& path) {
  std::ifstream file(std::string(SLIPSTACK_SOURCE_DIR "/") + path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace slipstack
