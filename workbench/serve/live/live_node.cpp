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

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kBetweenSignals = 50ms;  // a page draws no more often. Chosen.
constexpr int kPatience_ms = 200;       // for a sample; after so many of them the stream has ended
constexpr int kMostSilences = 10;
constexpr std::size_t kMotionSamples = 10;  // the axis moves where it went further than so many counts
constexpr std::int32_t kMotionCounts = 4;  // within so many samples. Chosen: an encoder at rest dithers by 1.
constexpr double kLeast_s = 2.0;           // of a recording: less has no stretch that a fit could hold out
constexpr double kMost_s = 3600.0;
constexpr std::int64_t kLongestGap =
    10;  // samples that a log may lack in one place: it is interpolated there

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> connections{0};
  return ++connections;
}

/// The longest part without a gap that no log may have.
std::vector<StreamSample> longest_part(const std::vector<StreamSample>& samples, const StreamedAxis& axis) {
  const double step = 1.0 / (axis.rate_Hz * axis.tick_s);
  std::size_t best = 0;
  std::size_t length = 0;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= samples.size(); ++i) {
    const bool ends = i == samples.size() || static_cast<double>(samples[i].tick - samples[i - 1].tick) >
                                                 step * static_cast<double>(kLongestGap);
    if (!ends) continue;
    if (i - begin > length) {
      best = begin;
      length = i - begin;
    }
    begin = i;
  }
  const auto first = samples.begin() + static_cast<std::ptrdiff_t>(best);
  return {first, first + static_cast<std::ptrdiff_t>(length)};
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

void LiveNode::set_state(const std::string& state, const std::string& error) {
  {
    const std::lock_guard lock(lock_);
    state_ = state;
    error_ = error;
  }
  events_.tell();
}

void LiveNode::run() {
  try {
    const std::unique_ptr<CanLink> link = connect_();
    SdoClient drive(*link, static_cast<std::uint8_t>(target_.node));
    std::unique_lock talking(talking_);
    drive.await_node();
    std::string status = drive_status(drive);
    auto stream = std::make_unique<DriveStream>(drive, target_.rate_Hz, DriveStream::With::observer);
    talking.unlock();
    {
      const std::lock_guard lock(lock_);
      status_ = std::move(status);
      axis_ = stream->axis();
    }
    set_state("live", "");
    std::string error;
    try {
      follow(drive, *stream);
    } catch (const std::exception& failure) {
      error = printable(failure.what());
    }
    talking.lock();
    stream.reset();  // restores the controller
    if (!error.empty()) set_state("lost", error);
  } catch (const std::exception& failure) {
    set_state("lost", printable(failure.what()));
  }
}

void LiveNode::follow(SdoClient& drive, DriveStream& stream) {
  auto told = std::chrono::steady_clock::now();
  for (int silences = 0; !stop_.load();) {
    if (const auto sample = stream.next(kPatience_ms)) {
      silences = 0;
      take(*sample);
    } else if (++silences > kMostSilences) {
      drive.fail("has stopped its stream; is it still on the bus, or does another master use SYNC?");
    }
    const auto now = std::chrono::steady_clock::now();
    if (now - told < kBetweenSignals) continue;
    told = now;
    events_.tell_live();
  }
}

void LiveNode::take(const StreamSample& sample) {
  const std::lock_guard lock(lock_);
  if (end_ == 0) first_tick_ = sample.tick;
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
  return {{"bus", printable(target_.bus)},
          {"node", target_.node},
          {"rate_Hz", target_.rate_Hz},
          {"state", state_},
          {"error", error_},
          {"status", status_},
          {"recording", recording_},
          {"notice", notice_},
          {"shown_s", kShown_s}};
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
  const std::lock_guard lock(lock_);
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
  samples = longest_part(samples, axis);
  if (samples.size() < all) {
    const std::lock_guard lock(lock_);
    notice_ = fmt::format(
        "The stream had gaps: of {} recorded samples the longest part without one became the log, {}. Lower "
        "the rate, or find out what delays the bus.",
        all, samples.size());
  }
  events_.tell();
  if (static_cast<double>(samples.size()) < kLeast_s * axis.rate_Hz) {
    throw UsageError(fmt::format("the recording has {} samples, less than {:g} s; record for longer",
                                 samples.size(), kLeast_s));
  }
  return recording_of(axis, samples);
}

}  // namespace slipstack::workbench
