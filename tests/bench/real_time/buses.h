// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <deque>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "tests/bench/real_time/watched_drive.h"

// The bus between a master and a drive, and the time that both have.
namespace slipstack::bench {

class Bus {
 public:
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  Bus(Bus&&) = delete;
  Bus& operator=(Bus&&) = delete;
  virtual ~Bus() = default;
  virtual void send(const CanFrame& frame) = 0;
  virtual bool receive(CanFrame& frame) = 0;
  /// Seconds since the begin.
  virtual double now_s() const = 0;
  virtual void wait_until(double time_s) = 0;
  /// What is seen counts from here on.
  virtual void mark() = 0;
  /// Ends the drive; what was seen in it.
  virtual const Inside& end() = 0;
};

/// A perfect clock: the drive's time is the master's.
class SteppedBus final : public Bus {
 public:
  explicit SteppedBus(WatchedDrive& drive) : drive_(drive) {}
  void send(const CanFrame& frame) override { to_drive_.push_back(frame); }
  bool receive(CanFrame& frame) override { return take(to_master_, frame); }
  double now_s() const override { return static_cast<double>(ticks_) * loop::kTick_s; }
  void wait_until(double time_s) override {
    while (now_s() < time_s) {
      drive_.tick(
          *inside_, 0.0, [this](CanFrame& frame) { return take(to_drive_, frame); },
          [this](const CanFrame& frame) { to_master_.push_back(frame); });
      ++ticks_;
    }
  }
  void mark() override { ++inside_->marks_wanted; }
  const Inside& end() override { return *inside_; }

 private:
  static bool take(std::deque<CanFrame>& frames, CanFrame& frame) {
    if (frames.empty()) return false;
    frame = frames.front();
    frames.pop_front();
    return true;
  }

  WatchedDrive& drive_;
  std::unique_ptr<Inside> inside_ = std::make_unique<Inside>();
  std::deque<CanFrame> to_drive_, to_master_;
  std::int64_t ticks_ = 0;
};

/// A perfect clock but for some times in which the master is held up: what was due then follows at once.
class HeldBus final : public Bus {
 public:
  struct Hold {
    double from_s, to_s;
  };
  HeldBus(WatchedDrive& drive, std::vector<Hold> holds) : bus_(drive), holds_(std::move(holds)) {}
  void send(const CanFrame& frame) override { bus_.send(frame); }
  bool receive(CanFrame& frame) override { return bus_.receive(frame); }
  double now_s() const override { return bus_.now_s(); }
  void wait_until(double time_s) override {
    for (const Hold& hold : holds_) {
      if (hold.from_s <= time_s && time_s < hold.to_s) time_s = hold.to_s;
    }
    bus_.wait_until(time_s);
  }
  void mark() override { bus_.mark(); }
  const Inside& end() override { return bus_.end(); }

 private:
  SteppedBus bus_;
  std::vector<Hold> holds_;  // in the order of time
};

/// The drive in a process of its own, which sleeps until each of its ticks; the master in this one, which
/// sleeps until each of its periods. Both by the machine's clock, absolutely, with a pair of sockets between
/// them. What the operating system makes of it is measured.
class ProcessBus final : public Bus {
 public:
  explicit ProcessBus(WatchedDrive& drive) {
    void* const memory =
        ::mmap(nullptr, sizeof(Inside), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    int ends[2] = {-1, -1};
    if (memory == MAP_FAILED || ::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0) std::abort();
    inside_ = new (memory) Inside;
    socket_ = ends[0];
    begin_ = now();
    process_ = ::fork();
    if (process_ == 0) {
      ::close(ends[0]);
      run(drive, ends[1]);
      ::_exit(0);
    }
    ::close(ends[1]);
  }
  ProcessBus(const ProcessBus&) = delete;
  ProcessBus& operator=(const ProcessBus&) = delete;
  ProcessBus(ProcessBus&&) = delete;
  ProcessBus& operator=(ProcessBus&&) = delete;
  ~ProcessBus() override {
    end();
    ::munmap(inside_, sizeof(Inside));
  }

  void send(const CanFrame& frame) override {
    EXPECT_EQ(::send(socket_, &frame, sizeof frame, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof frame));
  }
  bool receive(CanFrame& frame) override { return take(socket_, frame); }
  double now_s() const override { return now() - begin_; }
  void wait_until(double time_s) override { sleep_until(begin_ + time_s); }
  void mark() override { ++inside_->marks_wanted; }
  const Inside& end() override {
    if (socket_ >= 0) {
      ::close(socket_);
      socket_ = -1;
      int status = -1;
      EXPECT_EQ(::waitpid(process_, &status, 0), process_);
      EXPECT_EQ(status, 0) << "the drive's process";
    }
    return *inside_;
  }

 private:
  static double now() {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  static void sleep_until(double time_s) {
    timespec time{};
    time.tv_sec = static_cast<time_t>(time_s);
    time.tv_nsec = static_cast<long>(1e9 * (time_s - static_cast<double>(time.tv_sec)));
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
    }
  }
  static bool take(int socket, CanFrame& frame) {
    return ::recv(socket, &frame, sizeof frame, MSG_DONTWAIT) == static_cast<ssize_t>(sizeof frame);
  }

  // Until the master has closed its end. After a delay the ticks that are missing follow at once.
  void run(WatchedDrive& drive, int socket) {
    // A drive's tick waits for nobody; where the system does not allow that, it is told.
    sched_param priority{};
    priority.sched_priority = ::sched_get_priority_min(SCHED_FIFO);
    inside_->real_time_scheduling = ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
    CanFrame waiting;
    bool waits = false;
    for (std::int64_t tick = 1;; ++tick) {
      const double due_s = begin_ + static_cast<double>(tick) * loop::kTick_s;
      sleep_until(due_s);
      const double late_s = now() - due_s;
      inside_->turns.add(late_s);
      const ssize_t size = ::recv(socket, &waiting, sizeof waiting, MSG_DONTWAIT);
      if (size == 0) return;
      waits = size == static_cast<ssize_t>(sizeof waiting);
      drive.tick(
          *inside_, late_s,
          [&](CanFrame& frame) {
            if (!waits) return take(socket, frame);
            waits = false;
            frame = waiting;
            return true;
          },
          [&](const CanFrame& frame) {
            // At the end the master is gone.
            if (::send(socket, &frame, sizeof frame, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 && errno == EAGAIN)
              ++inside_->frames_not_sent;
          });
    }
  }

  Inside* inside_ = nullptr;
  int socket_ = -1;
  pid_t process_ = -1;
  double begin_ = 0.0;
};

}  // namespace slipstack::bench
