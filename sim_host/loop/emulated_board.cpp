// SPDX-License-Identifier: Apache-2.0
#include "sim_host/loop/emulated_board.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <string_view>

namespace slipstack::sim {

namespace {

constexpr std::size_t kMemoryBytes = 16U << 20;
constexpr int kNotStarted = 127;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Processors that this thread may run on; the host's side of the loop uses the first of them.
cpu_set_t allowed_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  return set;
}

int first_of(const cpu_set_t& set) {
  int processor = 0;
  while (processor < CPU_SETSIZE && !CPU_ISSET(processor, &set)) ++processor;
  return processor;
}

// Both sides poll each other without pause. On one processor each would wait until the scheduler switches to
// the other, thousands of times longer than a tick; therefore each gets a processor where there are two.
void use_other_processors() {
  cpu_set_t set = allowed_processors();
  if (CPU_COUNT(&set) < 2) return;
  CPU_CLR(first_of(set), &set);
  sched_setaffinity(0, sizeof set, &set);
}

void use_first_processor() {
  const cpu_set_t all = allowed_processors();
  if (CPU_COUNT(&all) < 2) return;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(first_of(all), &set);
  sched_setaffinity(0, sizeof set, &set);
}

// In the child: replaced by the emulator, and killed when the parent ends.
[[noreturn]] void become_emulator(const EmulatedBoard::Options& options, const std::string& machine,
                                  const std::string& image, int memory, int said, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotStarted);
  use_other_processors();
  // Ctrl-C goes to the parent, which then ends this process.
  setpgid(0, 0);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
  if (said >= 0) dup2(said, 1);
  const std::string board = machine + ",memory-backend=ram";
  const std::string backend =
      fmt::format("memory-backend-file,id=ram,share=on,size=16M,mem-path=/proc/self/fd/{}", memory);
  execlp(options.emulator.c_str(), "qemu-system-arm", "-M", board.c_str(), "-object", backend.c_str(),
         "-display", "none", "-monitor", "none", "-serial", "null", "-serial", options.can.c_str(),
         "-semihosting-config", "enable=on,target=native", "-kernel", image.c_str(),
         static_cast<char*>(nullptr));
  _exit(kNotStarted);
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return fmt::format("killed by signal {}", WTERMSIG(status));
  return fmt::format("status {}", WEXITSTATUS(status));
}

}  // namespace

EmulatedBoard::EmulatedBoard(const std::string& machine, const std::string& image, const Options& options)
    : options_(options) {
  if (!std::filesystem::is_regular_file(image)) {
    throw LoopError(
        image + ": no such image; build it: cmake --preset cortex-m4 && cmake --build --preset cortex-m4");
  }
  // Anonymous memory: no file remains, however the process ends.
  memory_ = memfd_create("slipstack-loop", 0);
  void* memory = MAP_FAILED;
  if (memory_ >= 0 && ftruncate(memory_, kMemoryBytes) == 0) {
    memory = mmap(nullptr, PlantMemory::kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
  }
  if (memory == MAP_FAILED) {
    release();
    throw LoopError("no memory to share with the emulator; 16 MB are needed");
  }
  link_ = static_cast<PlantLink*>(memory);
  fill_flash();
  int said[2] = {-1, -1};
  if (options_.can == "pty" && pipe2(said, O_CLOEXEC) != 0) said[0] = said[1] = -1;
  output_ = said[0];
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) become_emulator(options_, machine, image, memory_, said[1], parent);
  if (said[1] >= 0) close(said[1]);
  const auto begin = std::chrono::steady_clock::now();
  while (process_ > 0 && link_->magic != PlantLink::kMagic && !ended() &&
         seconds_since(begin) < options_.start_timeout_s) {
    usleep(1000);
  }
  if (process_ <= 0 || link_->magic != PlantLink::kMagic) refuse(machine, image);
  find_terminal();
  processors_ = allowed_processors();
  use_first_processor();
}

// As hal/mps2/memory_flash.h lays it out; with the marker the board uses the content as it is.
void EmulatedBoard::fill_flash() {
  constexpr std::string_view kMarker = "slipnv01";
  const std::span<std::byte> memory = flash();
  if (options_.pages.empty() || options_.pages.size() > memory.size() - kMarker.size()) return;
  std::memcpy(memory.data(), kMarker.data(), kMarker.size());
  std::memcpy(memory.data() + kMarker.size(), options_.pages.data(), options_.pages.size());
}

// QEMU says "char device redirected to /dev/pts/7 (label serial1)" before the image starts.
void EmulatedBoard::find_terminal() {
  if (output_ < 0) return;
  char text[256];
  const ssize_t got = read(output_, text, sizeof text);
  const std::string_view line(text, got > 0 ? static_cast<std::size_t>(got) : 0);
  const std::size_t begin = line.find("/dev/");
  if (begin == std::string_view::npos) return;
  can_terminal_ = line.substr(begin, line.find_first_of(" \n", begin) - begin);
}

EmulatedBoard::~EmulatedBoard() {
  if (CPU_COUNT(&processors_) > 0) sched_setaffinity(0, sizeof processors_, &processors_);
  release();
}

void EmulatedBoard::tick() {
  const std::uint32_t sequence = link_->host_sequence + 1;
  std::atomic_thread_fence(std::memory_order_seq_cst);
  link_->host_sequence = sequence;
  // An answer takes microseconds: poll without yielding the processor first, and yield only after that.
  for (int i = 0; i < 20000; ++i) {
    if (link_->guest_sequence == sequence) {
      std::atomic_thread_fence(std::memory_order_acquire);
      return;
    }
  }
  const auto begin = std::chrono::steady_clock::now();
  while (link_->guest_sequence != sequence) {
    if (ended()) {
      throw LoopError(fmt::format("the emulator ended in the middle of the run ({})", how_it_ended(status_)));
    }
    if (seconds_since(begin) > options_.tick_timeout_s) {
      throw LoopError(
          fmt::format("the emulator does not answer within {} s; is it stopped?", options_.tick_timeout_s));
    }
    sched_yield();
  }
  std::atomic_thread_fence(std::memory_order_acquire);
}

bool EmulatedBoard::ended() {
  if (process_ <= 0) return true;
  if (waitpid(process_, &status_, WNOHANG) != process_) return false;
  process_ = -1;
  return true;
}

void EmulatedBoard::refuse(const std::string& machine, const std::string& image) {
  const bool gone = ended();
  const bool missing = gone && WIFEXITED(status_) && WEXITSTATUS(status_) == kNotStarted;
  const std::string how = gone ? how_it_ended(status_) : "no answer";
  release();
  if (missing) {
    throw LoopError(options_.emulator + ": cannot be started; install the package qemu-system-arm");
  }
  throw LoopError(
      fmt::format("{}: does not run on {} ({}); is it an image for this board?", image, machine, how));
}

void EmulatedBoard::release() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  if (link_ != nullptr) munmap(link_, PlantMemory::kBytes);
  link_ = nullptr;
  if (memory_ >= 0) close(memory_);
  if (output_ >= 0) close(output_);
  memory_ = output_ = -1;
}

}  // namespace slipstack::sim
