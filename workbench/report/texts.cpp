// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/texts.h"

#include <fmt/format.h>

#include "workbench/base/quantity.h"

namespace slipstack::workbench {

std::string newtons(double value_N) {
  return quantity(value_N, "N");
}

std::string share(double value) {
  return fmt::format("{:.2f} %", 100.0 * value);
}

std::string counted(std::size_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string sentence(std::string words) {
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words + ".";
}

}  // namespace slipstack::workbench
