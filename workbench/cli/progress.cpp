// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
constexpr auto kPatience = 500ms;
constexpr auto kRedraw = 100ms;

}  // namespace

Progress::Progress() {
  if (isatty(STDERR_FILENO) == 1) painter_ = std::thread([this] { run(); });
}

Progress::~Progress() {
  finish();
}

void Progress::show(const std::string& stage, double fraction) {
  const std::lock_guard lock(lock_);
  stage_ = stage;
  fraction_ = fraction;
}

void Progress::finish() {
  if (!painter_.joinable()) return;
  {
    const std::lock_guard lock(lock_);
    done_ = true;
  }
  wake_.notify_one();
  painter_.join();
  if (shown_) fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

void Progress::run() {
  std::unique_lock lock(lock_);
  if (wake_.wait_for(lock, kPatience, [this] { return done_; })) return;
  do {
    draw();
  } while (!wake_.wait_for(lock, kRedraw, [this] { return done_; }));
}

void Progress::draw() {
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  const std::string share = fraction_ < 0.0 ? "     " : fmt::format("{:3.0f} %", 100.0 * fraction_);
  fmt::print(stderr, "\r\033[K{:<28} {} {:6.1f} s", stage_, share, elapsed_s);
  std::fflush(stderr);
  shown_ = true;
}

}  // namespace slipstack::workbench
