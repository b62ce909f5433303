// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/stop.h"

namespace slipstack::workbench {
namespace {

std::atomic<bool> asked_to_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ask(int) {
  asked_to_stop.store(true);
}

}  // namespace

StopSignal::StopSignal() {
  asked_to_stop.store(false);
  struct sigaction action {};
  action.sa_handler = ask;
  // The handler is removed after its first call: the second signal ends the program.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], nullptr, &before_[i]);
    // A signal that the caller had set to be ignored (nohup) stays ignored.
    if (before_[i].sa_handler != SIG_IGN) ::sigaction(kSignals[i], &action, nullptr);
  }
}

StopSignal::~StopSignal() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
}

const std::atomic<bool>& StopSignal::flag() {
  return asked_to_stop;
}

}  // namespace slipstack::workbench
