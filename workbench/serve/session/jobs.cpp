// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/jobs.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <new>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

/// Niceness of a job that gives way: a third of the processor beside a thread that does not (Linux,
/// sched(7)).
constexpr int kGivesWay = 5;

}  // namespace

void Jobs::give_way() {
  // On Linux the niceness is that of the calling thread, and inherited by those that it starts. Where it is
  // refused, answers take longer and nothing else.
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, kGivesWay));
}

Jobs::~Jobs() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

void Jobs::start(const std::string& what, Work work) {
  const std::lock_guard lock(lock_);
  if (running_) throw UsageError(fmt::format("{} is still running; cancel it or wait", what_));
  if (thread_.joinable()) thread_.join();  // it has ended
  token_ = std::make_shared<CancelToken>();
  running_ = true;
  what_ = what;
  stage_.clear();
  fraction_ = -1.0;
  error_.clear();
  outcome_.clear();
  start_ = std::chrono::steady_clock::now();
  thread_ = std::thread([this, work = std::move(work)] { run(work); });
  events_.tell();
}

void Jobs::run(const Work& work) {
  const std::shared_ptr<CancelToken> token = token_;
  std::string error;
  try {
    const CancelScope scope(token.get());
    Progress progress([this](const std::string& stage, double fraction) { show(stage, fraction); });
    work(progress);
  } catch (const std::bad_alloc&) {
    error = "out of memory; give a shorter log";
  } catch (const std::exception& failure) {
    error = printable(failure.what());
  } catch (...) {
    error = "it failed";
  }
  {
    const std::lock_guard lock(lock_);
    running_ = false;
    // A library on the way may have turned the cancellation into an error of its own.
    outcome_ = error.empty() ? "done" : token->is_cancelled() ? "cancelled" : "failed";
    error_ = outcome_ == "failed" ? error : "";
  }
  events_.tell();
}

void Jobs::show(const std::string& stage, double fraction) {
  {
    const std::lock_guard lock(lock_);
    stage_ = stage;
    fraction_ = fraction;
  }
  events_.tell_progress();
}

void Jobs::cancel() {
  const std::lock_guard lock(lock_);
  if (running_ && token_) token_->cancel();
}

bool Jobs::running() const {
  const std::lock_guard lock(lock_);
  return running_;
}

nlohmann::json Jobs::to_json() const {
  const std::lock_guard lock(lock_);
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return {{"running", running_},
          {"what", what_},
          {"stage", stage_},
          {"fraction", fraction_},
          {"error", error_},
          {"outcome", outcome_},
          {"elapsed_s", running_ ? elapsed_s : 0.0}};
}

}  // namespace slipstack::workbench
