// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/processes/mpi_group.h"

#include <sched.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "workbench/base/errors.h"

#ifdef SLIPSTACK_MPI
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace slipstack::workbench {
namespace {

/// Environment variables in which launchers give size and rank: Open MPI; MPICH, Intel MPI and Slurm (PMI);
/// PMIx gives the rank only.
constexpr std::array kSizes{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
constexpr std::array kRanks{"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"};

template <std::size_t N>
std::optional<int> number_of(const std::array<const char*, N>& names) {
  for (const char* name : names) {
    const char* text = std::getenv(name);
    if (text == nullptr) continue;
    const std::string_view digits(text);
    int number = 0;
    if (std::from_chars(digits.data(), digits.data() + digits.size(), number).ec == std::errc{}) {
      return number;
    }
  }
  return std::nullopt;
}

#ifdef SLIPSTACK_MPI

constexpr int kTag = 1;
/// Largest number of bytes of one MPI message; longer texts are sent in several.
constexpr std::size_t kMessage = std::size_t{1} << 28;

class MpiGroup final : public ProcessGroup {
 public:
  MpiGroup() {
    int threads = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &threads);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    if (rank_ == 0) use_all_processors();
  }
  ~MpiGroup() override { MPI_Finalize(); }
  MpiGroup(const MpiGroup&) = delete;
  MpiGroup& operator=(const MpiGroup&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  std::string broadcast(std::string message, int from) override {
    if (rank_ != from) return receive(from);
    for (int to = 0; to < size_; ++to) {
      if (to != from) send(to, message);
    }
    return message;
  }

  std::vector<std::string> gather(std::string message) override {
    if (rank_ != 0) {
      send(0, message);
      return {};
    }
    std::vector<std::string> messages{std::move(message)};
    for (int from = 1; from < size_; ++from) messages.push_back(receive(from));
    return messages;
  }

 private:
  /// mpirun binds each of few processes to one processor. The first may use all, because the others sleep
  /// while it searches.
  static void use_all_processors() {
    cpu_set_t all;
    CPU_ZERO(&all);
    for (int processor = 0; processor < CPU_SETSIZE; ++processor) CPU_SET(processor, &all);
    ::sched_setaffinity(0, sizeof all,
                        &all);  // a failure leaves the binding as it is
  }

  /// MPI's own wait polls without pause and would occupy the processor.
  static void wait(MPI_Request request) {
    using namespace std::chrono_literals;
    auto pause = 20us;
    for (int done = 0;;) {
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      if (done != 0) return;
      std::this_thread::sleep_for(pause);
      pause = std::min(2 * pause, 2000us);
    }
  }

  static void send_bytes(int to, const void* bytes, std::size_t count) {
    MPI_Request request{};
    MPI_Isend(bytes, static_cast<int>(count), MPI_BYTE, to, kTag, MPI_COMM_WORLD, &request);
    wait(request);
  }
  static void receive_bytes(int from, void* bytes, std::size_t count) {
    MPI_Request request{};
    MPI_Irecv(bytes, static_cast<int>(count), MPI_BYTE, from, kTag, MPI_COMM_WORLD, &request);
    wait(request);
  }

  /// The length, then the bytes.
  static void send(int to, const std::string& message) {
    const auto length = static_cast<std::uint64_t>(message.size());
    send_bytes(to, &length, sizeof length);
    for (std::size_t at = 0; at < message.size(); at += kMessage) {
      send_bytes(to, message.data() + at, std::min(kMessage, message.size() - at));
    }
  }
  static std::string receive(int from) {
    std::uint64_t length = 0;
    receive_bytes(from, &length, sizeof length);
    std::string message(static_cast<std::size_t>(length), '\0');
    for (std::size_t at = 0; at < message.size(); at += kMessage) {
      receive_bytes(from, message.data() + at, std::min(kMessage, message.size() - at));
    }
    return message;
  }

  int rank_ = 0;
  int size_ = 1;
};

#endif

}  // namespace

bool is_first_started() {
  return number_of(kRanks).value_or(0) == 0;
}

std::unique_ptr<ProcessGroup> join_process_group() {
  const std::optional<int> started = number_of(kSizes);
#ifdef SLIPSTACK_MPI
  if (!started && !number_of(kRanks)) return std::make_unique<SingleProcess>();
  auto group = std::make_unique<MpiGroup>();
  if (group->size() == 1 && started.value_or(1) > 1) {
    throw InputError(
        "several processes were started together, but not by the MPI that slipstack was built with; use its "
        "mpirun (Open MPI where `mpirun --version` says so), or start one process");
  }
  return group;
#else
  if (started.value_or(1) > 1) {
    throw InputError(
        "several processes were started together, but slipstack was built without MPI; install "
        "libopenmpi-dev and build again, or start one process");
  }
  return std::make_unique<SingleProcess>();
#endif
}

}  // namespace slipstack::workbench
