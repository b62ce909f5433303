// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/live_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "workbench/base/text.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/report/json_values.h"
#include "workbench/serve/live/kept_part.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kBetweenSignals = 50ms;     // a page draws no more often. Chosen.
constexpr auto kBetweenQuestions = 200ms;  // for the state: as fast as one reads. Chosen.
constexpr auto kBetweenTries = 1s;         // to reach a drive that is lost. Chosen.
constexpr int kPatience_ms = 200;          // for a sample; after so many of them the stream has ended
constexpr int kMostSilences = 3;
constexpr auto kMostCatchingUp = 5s;  // with samples that wait, before a new model is told of all the same
constexpr std::size_t kMotionSamples = 10;  // the axis moves where it went further than so many counts
constexpr std::int32_t kMotionCounts = 4;  // within so many samples. Chosen: an encoder at rest dithers by 1.
constexpr double kMost_s = 3600.0;         // of a recording

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> connections{0};
  return ++connections;
}

float value_or_zero(float value) {
  return std::isfinite(value) ? value : 0.0F;
}

}  // namespace

LiveNode::LiveNode(Events& events, std::mutex& talking, Target target, Connect connect)
    : events_(events),
      talking_(talking),
      number_(next_number()),
      target_(std::move(target)),
      connect_(std::move(connect)) {
  parts_.push_back({"the model that was there", 0.0, 0, 0.0, 0.0, 0.0});
  thread_ = std::thread([this] { run(); });
}

LiveNode::~LiveNode() {
  stop_.store(true);
  thread_.join();
}

void LiveNode::run() {
  while (!stop_.load()) {
    try {
      if (!paused_.load()) attend();
    } catch (const std::exception& failure) {
      if (stop_.load()) return;
      if (!paused_.load()) lost(printable(failure.what()));
    }
    if (paused_.load()) {
      set_state("paused");
      while (paused_.load() && !stop_.load()) std::this_thread::sleep_for(5ms);
      set_state("connecting");
      continue;
    }
    const auto again = std::chrono::steady_clock::now() + kBetweenTries;
    while (!stop_.load() && !paused_.load() && std::chrono::steady_clock::now() < again)
      std::this_thread::sleep_for(5ms);
  }
}

void LiveNode::set_state(const char* state) {
  {
    const std::lock_guard lock(lock_);
    state_ = state;
    error_.clear();
  }
  events_.tell();
}

void LiveNode::pause() {
  paused_.store(true);
  for (;;) {
    {
      const std::lock_guard lock(lock_);
      if (state_ == "paused") return;
    }
    std::this_thread::sleep_for(5ms);
  }
}

void LiveNode::resume() {
  paused_.store(false);
}

void LiveNode::lost(const std::string& why) {
  {
    const std::lock_guard lock(lock_);
    if (state_ == "live") happened_.lost(why);
    if (state_ == "lost" && error_ == why) return;  // still
    state_ = "lost";
    error_ = why;
  }
  events_.tell();
}

/// Asks for the state during its life.
class LiveNode::Asking {
 public:
  Asking(LiveNode& node, SdoClient& drive) : thread_([this, &node, &drive] { run(node, drive); }) {}
  Asking(const Asking&) = delete;
  Asking& operator=(const Asking&) = delete;
  ~Asking() {
    ended_.store(true);
    thread_.join();
  }

 private:
  void run(LiveNode& node, SdoClient& drive) {
    while (!ended_.load()) {
      try {
        node.take_state(ask_state(drive));
      } catch (const std::exception& failure) {
        const std::lock_guard lock(node.lock_);
        node.no_answer_ = printable(failure.what());
      }
      const auto next = std::chrono::steady_clock::now() + kBetweenQuestions;
      while (!ended_.load() && std::chrono::steady_clock::now() < next) std::this_thread::sleep_for(5ms);
    }
  }

  std::atomic<bool> ended_{false};
  std::thread thread_;  ///< last
};

void LiveNode::attend() {
  const std::unique_ptr<CanLink> stream_link = connect_();
  const std::unique_ptr<CanLink> question_link = connect_();
  const auto node = static_cast<std::uint8_t>(target_.node);
  SdoClient drive(*stream_link, node, &talking_);
  SdoClient asked(*question_link, node, &talking_);
  static_cast<void>(asked.read(0x1000, 0));
  std::string status = drive_status(asked);
  const DriveState state = ask_state(asked);
  const std::uint32_t last_error = asked.read(0x1003, 0) > 0 ? asked.read(0x1003, 1) : 0;
  DriveStream stream(drive, target_.rate_Hz, DriveStream::With::observer,
                     {&owed_, [this](const CanFrame& frame) { take_message(frame); }});
  {
    const std::lock_guard lock(lock_);
    status_ = std::move(status);
    axis_ = stream.axis();
    state_ = "live";
    error_.clear();
    anew_ = true;
    no_answer_.clear();
    happened_.connected(state, last_error);
  }
  events_.tell();
  // In a thread of its own: a question waits for its turn, and samples that wait meanwhile would be counted
  // to a model that was deployed after them.
  const Asking asking(*this, asked);
  follow(stream);
}

void LiveNode::take_state(const DriveState& state) {
  {
    const std::lock_guard lock(lock_);
    no_answer_.clear();
    if (!happened_.take(state)) return;
  }
  events_.tell();
}

void LiveNode::follow(DriveStream& stream) {
  auto told = std::chrono::steady_clock::now();
  for (int silences = 0; !stop_.load() && !paused_.load();) {
    auto sample = stream.next(0);
    if (!sample) {
      {
        const std::lock_guard lock(lock_);
        ++times_caught_up_;
      }
      caught_up_.notify_all();
      sample = stream.next(kPatience_ms);
    }
    if (sample) {
      silences = 0;
      take(*sample);
    } else if (++silences > kMostSilences) {
      const std::lock_guard lock(lock_);
      throw UsageError(!no_answer_.empty()
                           ? no_answer_
                           : fmt::format("node {}: has stopped its stream; is it still on the bus, or does "
                                         "another master use SYNC?",
                                         target_.node));
    }
    const auto now = std::chrono::steady_clock::now();
    if (now - told < kBetweenSignals) continue;
    told = now;
    events_.tell_live();
  }
}

void LiveNode::take_message(const CanFrame& frame) {
  if (frame.id == kErrorControlId + static_cast<std::uint32_t>(target_.node)) {
    // Boot-up (CiA 301, 7.2.8.3.3): what was set for the stream is gone.
    if (frame.length == 1 && frame.data[0] == 0)
      throw UsageError(fmt::format("node {}: has started anew", target_.node));
    return;
  }
  if (frame.length != 8) return;
  {
    const std::lock_guard lock(lock_);
    happened_.take_emergency(frame);
  }
  events_.tell();
}

void LiveNode::take(StreamSample sample) {
  const std::lock_guard lock(lock_);
  const auto now = std::chrono::steady_clock::now();
  if (end_ == 0) first_tick_ = sample.tick;
  if (anew_ && end_ > 0) {
    const double away_s = std::chrono::duration<double>(now - seen_).count();
    const auto last = shown_.empty() ? first_tick_ : shown_.back().tick;
    tick_offset_ = last + std::max<std::int64_t>(1, std::llround(away_s / axis_.tick_s)) - sample.tick;
  }
  anew_ = false;
  seen_ = now;
  sample.tick += tick_offset_;
  ++end_;
  shown_.push_back(sample);
  if (static_cast<double>(shown_.size()) > kShown_s * axis_.rate_Hz) shown_.pop_front();
  if (recording_ && static_cast<double>(recorded_.size()) < kMost_s * axis_.rate_Hz) {
    recorded_.push_back(sample);
  }
  if (shown_.size() <= kMotionSamples) return;
  const StreamSample& before = shown_[shown_.size() - 1 - kMotionSamples];
  if (std::abs(sample.counts - before.counts) <= kMotionCounts) return;
  Part& part = parts_.back();
  const double residual_N = static_cast<double>(value_or_zero(sample.residual_N));
  const double error_m = static_cast<double>(value_or_zero(sample.error_m));
  ++part.moving;
  part.residual_squares += residual_N * residual_N;
  part.error_squares += error_m * error_m;
  part.largest_error_m = std::max(part.largest_error_m, std::abs(error_m));
}

json LiveNode::to_json() const {
  const std::lock_guard lock(lock_);
  json page = {{"bus", printable(target_.bus)},
               {"node", target_.node},
               {"rate_Hz", target_.rate_Hz},
               {"state", state_},
               {"error", error_},
               {"status", status_},
               {"recording", recording_},
               {"notice", notice_},
               {"shown_s", kShown_s}};
  happened_.add_to(page);
  return page;
}

std::uint64_t LiveNode::end() const {
  const std::lock_guard lock(lock_);
  return end_;
}

json LiveNode::since(std::uint64_t first) const {
  const std::lock_guard lock(lock_);
  const std::uint64_t kept = end_ - shown_.size();
  first = std::clamp(first, kept, end_);
  json signals = {{"connection", number_}, {"first", first}, {"end", end_}, {"recorded", recorded_.size()}};
  const auto column = [&](const char* name, auto&& value) {
    json list = json::array();
    for (std::uint64_t i = first; i < end_; ++i) list.push_back(number_json(value(shown_[i - kept])));
    signals[name] = std::move(list);
  };
  column("time_s",
         [&](const StreamSample& one) { return static_cast<double>(one.tick - first_tick_) * axis_.tick_s; });
  column("position_m", [&](const StreamSample& one) { return one.counts * axis_.resolution_m; });
  column("force_N", [&](const StreamSample& one) { return one.current_A * axis_.constant_N_per_A; });
  column("error_m", [](const StreamSample& one) { return static_cast<double>(one.error_m); });
  column("residual_N", [](const StreamSample& one) { return static_cast<double>(one.residual_N); });
  signals["parts"] = json::array();
  for (const Part& part : parts_) {
    const auto rms = [&](double squares) {
      return part.moving == 0 ? json(nullptr)
                              : number_json(std::sqrt(squares / static_cast<double>(part.moving)));
    };
    signals["parts"].push_back({{"label", printable(part.label)},
                                {"begin_s", part.begin_s},
                                {"moving_s", static_cast<double>(part.moving) / target_.rate_Hz},
                                {"residual_rms_N", rms(part.residual_squares)},
                                {"error_rms_m", rms(part.error_squares)},
                                {"largest_error_m", part.largest_error_m}});
  }
  return signals;
}

void LiveNode::model_changed(const std::string& label) {
  std::unique_lock lock(lock_);
  // The first time may be that of a look before this call.
  caught_up_.wait_for(lock, kMostCatchingUp, [this, seen = times_caught_up_] {
    return times_caught_up_ >= seen + 2 || state_ != "live";
  });
  const double now_s =
      shown_.empty() ? 0.0 : static_cast<double>(shown_.back().tick - first_tick_) * axis_.tick_s;
  parts_.push_back({label, now_s, 0, 0.0, 0.0, 0.0});
}

void LiveNode::start_recording() {
  {
    const std::lock_guard lock(lock_);
    if (state_ != "live") throw UsageError("no controller is connected; connect to one first");
    recorded_.clear();
    notice_.clear();
    recording_ = true;
  }
  events_.tell();
}

Recording LiveNode::stop_recording() {
  std::vector<StreamSample> samples;
  StreamedAxis axis;
  {
    const std::lock_guard lock(lock_);
    if (!recording_) throw UsageError("nothing is being recorded");
    recording_ = false;
    samples.swap(recorded_);
    axis = axis_;
  }
  const std::size_t all = samples.size();
  samples = part_to_keep(samples, axis);
  if (samples.size() < all) {
    const std::lock_guard lock(lock_);
    notice_ = fmt::format(
        "The stream had gaps: of {} recorded samples the longest part without one in which the axis moves "
        "became the log, {}. Lower the rate, or find out what delays the bus.",
        all, samples.size());
  }
  events_.tell();
  if (!is_long_enough(samples.size(), axis)) {
    throw UsageError(fmt::format("the recording has {} samples, less than {:g} s; record for longer",
                                 samples.size(), kLeastRecording_s));
  }
  return recording_of(axis, samples);
}

}  // namespace slipstack::workbench
