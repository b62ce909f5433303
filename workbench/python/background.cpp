// SPDX-License-Identifier: Apache-2.0
#include "workbench/python/background.h"

#include <chrono>
#include <utility>

#include "workbench/base/axis_units.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;

// A signal is seen after this time at the latest; a person takes twice as long for an answer to be at once
// (Nielsen 1993: 0.1 s).
constexpr auto kPatience = 50ms;

std::timed_mutex& one_at_a_time() {
  static std::timed_mutex lock;
  return lock;
}

}  // namespace

Background::Background(std::function<void(Progress&)> work)
    : thread_([this, does = std::move(work)] { run(does); }) {}

Background::~Background() {
  cancel();
}

bool Background::wait(std::vector<Stage>& stages) {
  stages.clear();
  std::unique_lock lock(lock_);
  news_.wait_for(lock, kPatience, [this] { return ended_ || !stages_.empty(); });
  std::swap(stages, stages_);
  return ended_;
}

void Background::cancel() {
  token_.cancel();
  if (thread_.joinable()) thread_.join();
}

void Background::rethrow() const {
  if (fault_) std::rethrow_exception(fault_);
}

void Background::run(const std::function<void(Progress&)>& work) {
  try {
    const CancelScope scope(&token_);
    std::unique_lock alone(one_at_a_time(), std::defer_lock);
    while (!alone.try_lock_for(kPatience)) throw_if_cancelled();
    forget_axis();
    Progress progress([this](const std::string& stage, double fraction) { show(stage, fraction); });
    work(progress);
  } catch (...) {
    fault_ = std::current_exception();
  }
  const std::lock_guard lock(lock_);
  ended_ = true;
  news_.notify_one();
}

void Background::show(const std::string& stage, double fraction) {
  const std::lock_guard lock(lock_);
  if (!stages_.empty() && stages_.back().name == stage) {
    stages_.back().fraction = fraction;
  } else {
    stages_.push_back({stage, fraction});
  }
  news_.notify_one();
}

}  // namespace slipstack::workbench
