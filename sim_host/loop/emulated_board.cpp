// SPDX-License-Identifier: Apache-2.0
#include "sim_host/loop/emulated_board.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <stdexcept>

namespace slipstack::sim {

namespace {

constexpr std::size_t kMemoryBytes = 16U << 20;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// In the child: replaced by the emulator, and killed when the parent ends.
[[noreturn]] void become_emulator(const std::string& machine, const std::string& image,
                                  const std::string& memory, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
  const std::string board = machine + ",memory-backend=ram";
  const std::string backend = "memory-backend-file,id=ram,share=on,size=16M,mem-path=" + memory;
  execlp("qemu-system-arm", "qemu-system-arm", "-M", board.c_str(), "-object", backend.c_str(), "-display",
         "none", "-monitor", "none", "-serial", "null", "-semihosting-config", "enable=on,target=native",
         "-kernel", image.c_str(), static_cast<char*>(nullptr));
  _exit(127);
}

}  // namespace

EmulatedBoard::EmulatedBoard(const std::string& machine, const std::string& image, double start_timeout_s) {
  if (!std::filesystem::is_regular_file(image)) {
    throw std::runtime_error(
        image + ": no such image; build it: cmake --preset cortex-m4 && cmake --build --preset cortex-m4");
  }
  std::string path =
      (std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp") + std::string("/slipstack-loop-XXXXXX");
  const int file = mkstemp(path.data());
  if (file < 0) throw std::runtime_error(path + ": cannot be created");
  memory_path_ = path;
  void* memory = MAP_FAILED;
  if (ftruncate(file, kMemoryBytes) == 0) {
    memory = mmap(nullptr, sizeof(PlantLink), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  }
  close(file);
  if (memory == MAP_FAILED) {
    release();
    throw std::runtime_error(path + ": cannot be mapped");
  }
  link_ = static_cast<PlantLink*>(memory);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) become_emulator(machine, image, memory_path_, parent);
  const auto begin = std::chrono::steady_clock::now();
  while (process_ > 0 && link_->magic != PlantLink::kMagic && !ended() &&
         seconds_since(begin) < start_timeout_s) {
    usleep(1000);
  }
  if (process_ > 0 && link_->magic == PlantLink::kMagic) return;
  release();
  throw std::runtime_error(image + ": does not start in qemu-system-arm -M " + machine +
                           " (package qemu-system-arm; machine mps2-an386)");
}

EmulatedBoard::~EmulatedBoard() {
  release();
}

void EmulatedBoard::tick(double timeout_s) {
  const std::uint32_t sequence = link_->host_sequence + 1;
  std::atomic_thread_fence(std::memory_order_seq_cst);
  link_->host_sequence = sequence;
  // Answers take microseconds: look without giving the processor away, and only then politely.
  for (int i = 0; i < 20000; ++i) {
    if (link_->guest_sequence == sequence) {
      std::atomic_thread_fence(std::memory_order_acquire);
      return;
    }
  }
  const auto begin = std::chrono::steady_clock::now();
  while (link_->guest_sequence != sequence) {
    if (ended()) throw std::runtime_error("the emulator ended in the middle of the run");
    if (seconds_since(begin) > timeout_s) throw std::runtime_error("the emulator does not answer");
    sched_yield();
  }
  std::atomic_thread_fence(std::memory_order_acquire);
}

bool EmulatedBoard::ended() {
  if (process_ <= 0) return true;
  int status = 0;
  if (waitpid(process_, &status, WNOHANG) != process_) return false;
  process_ = -1;
  return true;
}

void EmulatedBoard::release() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  if (link_ != nullptr) munmap(link_, sizeof(PlantLink));
  link_ = nullptr;
  if (!memory_path_.empty()) unlink(memory_path_.c_str());
}

}  // namespace slipstack::sim
