// SPDX-License-Identifier: Apache-2.0
#include "workbench/console/progress.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "workbench/base/cancel.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
constexpr auto kDelay = 500ms;  // shorter commands show nothing; chosen
constexpr auto kRedraw = 100ms;

/// Whether standard error goes to a terminal. Under mpirun it is a pipe to mpirun: then mpirun's own standard
/// error is examined.
bool goes_to_terminal() {
  if (isatty(STDERR_FILENO) == 1) return true;
  if (std::getenv("OMPI_COMM_WORLD_RANK") == nullptr) return false;
  const int descriptor =
      ::open(fmt::format("/proc/{}/fd/2", ::getppid()).c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool terminal = isatty(descriptor) == 1;
  ::close(descriptor);
  return terminal;
}

}  // namespace

Progress::Progress() {
  if (goes_to_terminal()) painter_ = std::thread([this] { run(); });
}

Progress::~Progress() {
  finish();
}

void Progress::show(const std::string& stage, double fraction) {
  throw_if_cancelled();
  if (listener_) listener_(stage, fraction);
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
  if (wake_.wait_for(lock, kDelay, [this] { return done_; })) return;
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
