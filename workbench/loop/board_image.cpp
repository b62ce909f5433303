// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/board_image.h"

#include <array>
#include <filesystem>

namespace slipstack::workbench {

std::string board_image(const std::string& board, const std::string& image) {
  if (!image.empty()) return image;
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::string name = "slipstack-" + board + ".elf";
  const auto beside = program.parent_path();
  const std::array candidates = {beside / name, beside / "../share/slipstack" / name,
                                 beside / "../../cortex-m4/bin" / name};
  for (const auto& candidate : candidates) {
    if (std::filesystem::is_regular_file(candidate, ignored)) {
      return candidate.lexically_normal().string();
    }
  }
  return candidates.back().lexically_normal().string();
}

}  // namespace slipstack::workbench
