// SPDX-License-Identifier: Apache-2.0
#include "workbench/console/cleanup.h"

#include <unistd.h>

#include <atomic>
#include <stdexcept>

namespace slipstack::workbench {
namespace {

// What the handler may read: pointers into the living Cleanup.
std::array<std::atomic<const char*>, Cleanup::kMostFiles> doomed{};
static_assert(std::atomic<const char*>::is_always_lock_free);

void remove_all() {
  for (const auto& file : doomed) {
    if (const char* path = file.load()) ::unlink(path);
  }
}

// Only what a signal handler may call.
void end(int signal) {
  remove_all();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

Cleanup::Cleanup(std::vector<std::string> files) : files_(std::move(files)) {
  if (files_.size() > kMostFiles) throw std::logic_error("more files than a Cleanup holds");
  for (std::size_t i = 0; i < files_.size(); ++i) doomed[i] = files_[i].c_str();
  struct sigaction action {};
  action.sa_handler = end;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], nullptr, &before_[i]);
    // Who started the program may have wished for some to be ignored (nohup).
    if (before_[i].sa_handler == SIG_DFL) ::sigaction(kSignals[i], &action, nullptr);
  }
}

Cleanup::~Cleanup() {
  remove_all();
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
  for (auto& file : doomed) file = nullptr;
}

SignalsHeld::SignalsHeld() {
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, &before_);
}

SignalsHeld::~SignalsHeld() {
  ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace slipstack::workbench
