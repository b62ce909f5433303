// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "workbench/can/drive/drive_stream.h"
#include "workbench/serve/http/events.h"
#include "workbench/serve/live/drive_events.h"

namespace slipstack::workbench {

/// A controller that is watched while it runs: what it streams (drive_stream.h) for the pages, a recording of
/// it as a log, the errors before and after each model that was put on it, and what it says of itself: state,
/// mode, faults. Its thread owns the links; the controller is only read, but for the communication objects of
/// the stream, which are restored. Where it is lost, it is tried again until it is there or this ends.
/// All members may be called from any thread.
class LiveNode {
 public:
  static constexpr double kShown_s = 20.0;  ///< of the signals that a page gets when it comes

  struct Target {
    std::string bus;  ///< CAN interface; empty: the simulated axis
    int node = 5;
    double rate_Hz = 500.0;
  };
  using Connect = std::function<std::unique_ptr<CanLink>()>;

  /// `talking`: the turn of those in this program that ask the controller for its objects (SdoClient).
  /// `connect` is called for two links, and anew after each loss.
  LiveNode(Events& events, std::mutex& talking, Target target, Connect connect);
  /// Ends the stream and restores the controller.
  ~LiveNode();
  LiveNode(const LiveNode&) = delete;
  LiveNode& operator=(const LiveNode&) = delete;

  const Target& target() const { return target_; }
  /// Another one for each connection.
  std::uint64_t number() const { return number_; }
  /// {bus, node, rate_Hz, state: connecting | live | lost | paused, error, status, recording, notice}, and
  /// what DriveEvents adds: what changes seldom.
  nlohmann::json to_json() const;
  /// Number of the next sample.
  std::uint64_t end() const;
  /// Samples from number `first` on, those that are still kept: {connection, first, end, time_s, position_m,
  /// force_N, error_m, residual_N, recorded, parts}. `parts`: for each model since the connection the rms
  /// errors while the axis moved.
  nlohmann::json since(std::uint64_t first) const;

  /// Leaves the controller to another work of this program: ends the stream, restores the controller, and
  /// returns when that is done; until resume() nothing is asked.
  void pause();
  void resume();

  /// A model was put on the controller: a new part begins, once the samples from before it that still wait to
  /// be received are counted to the part they belong to (at most 5 s).
  void model_changed(const std::string& label);

  /// Throws UsageError unless the controller is live.
  void start_recording();
  /// The recording as a log; where the stream had gaps too long for one, the longest part
  /// between them in which the axis moves. Throws UsageError where there is none, or one too short for any
  /// use.
  Recording stop_recording();

 private:
  /// What was seen with one model.
  struct Part {
    std::string label;
    double begin_s = 0.0;
    std::size_t moving = 0;  ///< samples
    double residual_squares = 0.0;
    double error_squares = 0.0;
    double largest_error_m = 0.0;
  };

  void run();
  /// From one connection to its end; throws what it ended by.
  void attend();
  class Asking;
  void follow(DriveStream& stream);
  void take_state(const DriveState& state);
  void take(StreamSample sample);
  void take_message(const CanFrame& frame);
  void lost(const std::string& why);
  void set_state(const char* state);

  Events& events_;
  std::mutex& talking_;
  const std::uint64_t number_;
  const Target target_;
  const Connect connect_;
  mutable std::mutex lock_;  ///< of what follows
  std::string state_ = "connecting";
  std::string error_;
  std::string status_;
  std::string notice_;  ///< of the last recording
  StreamedAxis axis_;
  std::deque<StreamSample> shown_;
  std::uint64_t end_ = 0;
  std::int64_t first_tick_ = 0;
  DriveEvents happened_;
  std::string no_answer_;  ///< why the last question had none
  // The drive's ticks begin anew with each connection; these go on.
  bool anew_ = false;
  std::int64_t tick_offset_ = 0;
  std::chrono::steady_clock::time_point seen_;  ///< the last sample
  std::vector<Part> parts_;
  std::uint64_t times_caught_up_ = 0;  ///< with the samples that waited
  std::condition_variable caught_up_;
  bool recording_ = false;
  std::vector<StreamSample> recorded_;
  std::vector<RestoredObjects::Before> owed_;  ///< of this thread: to be restored when it is there again
  std::atomic<bool> stop_{false};
  std::atomic<bool> paused_{false};
  std::thread thread_;  ///< last: it ends before the rest goes
};

}  // namespace slipstack::workbench
