// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace slipstack::workbench {

Progress::Progress() : watched_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void Progress::show(const std::string& stage, double fraction) {
  if (!watched_) return;
  const std::lock_guard lock(lock_);
  const auto now = Clock::now();
  if (now - start_ < std::chrono::milliseconds(500) || now - last_ < std::chrono::milliseconds(50)) return;
  last_ = now;
  shown_ = true;
  fmt::print(stderr, "\r\033[K{:<28} {:3.0f} %  {:5.1f} s", stage, 100.0 * fraction,
             std::chrono::duration<double>(now - start_).count());
  std::fflush(stderr);
}

}  // namespace slipstack::workbench
