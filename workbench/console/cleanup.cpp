// SPDX-License-Identifier: Apache-2.0
#include "workbench/console/cleanup.h"

#include <unistd.h>

#include <atomic>
#include <stdexcept>

namespace slipstack::workbench {
namespace {

// Paths to remove, for the signal handler: pointers into the strings of the Cleanup that exists now.
std::array<std::atomic<const char*>, Cleanup::kMostFiles> paths_to_remove{};
static_assert(std::atomic<const char*>::is_always_lock_free);

void remove_all() {
  for (const auto& file : paths_to_remove) {
    if (const char* path = file.load()) ::unlink(path);
  }
}

// The signal handler: calls only functions that are async-signal-safe (POSIX.1-2017, 2.4.3).
void remove_and_end(int signal) {
  remove_all();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

Cleanup::Cleanup(std::vector<std::string> files) : files_(std::move(files)) {
  if (files_.size() > kMostFiles) throw std::logic_error("more files than a Cleanup holds");
  for (std::size_t i = 0; i < files_.size(); ++i) paths_to_remove[i] = files_[i].c_str();
  struct sigaction action {};
  action.sa_handler = remove_and_end;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], nullptr, &before_[i]);
    // A signal that the caller set to be ignored (nohup) stays ignored.
    if (before_[i].sa_handler == SIG_DFL) ::sigaction(kSignals[i], &action, nullptr);
  }
}

Cleanup::~Cleanup() {
  remove_all();
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
  for (auto& file : paths_to_remove) file = nullptr;
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
