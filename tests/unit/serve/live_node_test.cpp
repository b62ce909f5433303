// SPDX-License-Identifier: Apache-2.0
// A controller that is watched: its signals, the errors model by model, recordings, and what goes wrong.
#include "workbench/serve/live/live_node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "firmware/control/hunting/hunting_watch.h"
#include "firmware/control/supervision/faults.h"
#include "tests/unit/serve/recorded_log.h"
#include "workbench/can/drive/drive_words.h"
#include "workbench/serve/live/driven_axis.h"
#include "workbench/serve/live/simulated_axis.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

const SimulatedAxis kAxis{11, "viscous", 5.0, 20.0};
constexpr auto kPatience = 20s;
const Show kQuiet = [](const std::string&, double) {};

template <class Condition>
bool await(Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

struct Watched {
  Events events;
  std::mutex talking;
  SimulatedController controller{kAxis};
  std::unique_ptr<LiveNode> live;

  std::unique_ptr<CanLink> link() {
    return controller.connect(SimulatedController::Wait::as_fast_as_possible);
  }
  void watch() {
    live = std::make_unique<LiveNode>(events, talking, LiveNode::Target{"", 5, 500.0},
                                      [this] { return link(); });
    ASSERT_TRUE(await([&] { return live->end() > 50; })) << live->to_json();
  }
  /// Its samples still wait for the thread that watches.
  void move_unseen(double travel_m) {
    const auto cable = link();
    SdoClient drive(*cable, 5, &talking);
    move_to_and_fro(drive, travel_m, 1, kQuiet);
  }
  void move(double travel_m) {
    move_unseen(travel_m);
    // Frames of the move may still wait for the thread that watches.
    const std::uint64_t now = live->end();
    ASSERT_TRUE(await([&] { return live->end() > now + 500; }));
  }
};

TEST(LiveNode, ShowsTheSignalsAndTheErrorsModelByModel) {
  Watched bench;
  bench.watch();
  EXPECT_EQ(bench.live->to_json().at("state"), "live");
  const json rest = bench.live->since(0);
  EXPECT_EQ(rest.at("parts").at(0).at("moving_s"), 0.0) << "an encoder that dithers is no motion";
  EXPECT_TRUE(rest.at("parts").at(0).at("residual_rms_N").is_null());
  bench.move_unseen(0.02);
  bench.live->model_changed("version 7");
  bench.move(0.02);
  const json seen = bench.live->since(0);
  ASSERT_EQ(seen.at("parts").size(), 2U);
  EXPECT_NEAR(seen.at("parts").at(0).at("moving_s"), seen.at("parts").at(1).at("moving_s"), 0.1)
      << "the samples of a move that wait when the model changes are of the model before";
  EXPECT_EQ(seen.at("parts").at(1).at("label"), "version 7");
  EXPECT_GT(seen.at("parts").at(1).at("begin_s"), 0.0);
  for (const json& part : seen.at("parts")) {
    EXPECT_GT(part.at("moving_s"), 0.1);
    EXPECT_LT(part.at("moving_s"), 5.0);
    EXPECT_GT(part.at("residual_rms_N"), 1.0) << "a model of the mass alone lacks the friction";
    EXPECT_LT(part.at("residual_rms_N"), 100.0);
    EXPECT_GE(part.at("largest_error_m"), part.at("error_rms_m"));
  }
  const json& time_s = seen.at("time_s");
  ASSERT_GT(time_s.size(), 60U);
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    ASSERT_NEAR(time_s[i].get<double>() - time_s[i - 1].get<double>(), 2e-3, 1e-9) << i;
  }
  double lowest_m = 1e9;
  double highest_m = -1e9;
  for (const json& one : seen.at("position_m")) {
    lowest_m = std::min(lowest_m, one.get<double>());
    highest_m = std::max(highest_m, one.get<double>());
  }
  EXPECT_NEAR(highest_m - lowest_m, 0.02, 1e-3);
  const std::uint64_t end = seen.at("end");
  EXPECT_GE(bench.live->since(end).at("first"), end) << "only what is new";
}

TEST(LiveNode, ARecordingIsALogAndOneThatIsTooShortIsNot) {
  Watched bench;
  bench.watch();
  EXPECT_THROW(bench.live->stop_recording(), UsageError);
  bench.live->start_recording();
  EXPECT_TRUE(bench.live->to_json().at("recording"));
  EXPECT_THROW(bench.live->stop_recording(), UsageError) << "too short";
  bench.live->start_recording();
  bench.move(0.02);
  ASSERT_TRUE(await([&] { return bench.live->since(bench.live->end()).at("recorded") > 1500; }));
  const Recording recording = bench.live->stop_recording();
  EXPECT_GT(recording.samples, 1500U);
  EXPECT_EQ(recording.lost, 0U);
  const Log log = test::read_recorded(recording.log);
  EXPECT_NEAR(log.sample_rate_Hz, 500.0, 1e-6);
  EXPECT_EQ(log.position_m.size(), recording.samples);
}

/// A link that loses as many of the frames that it receives as `to_lose` says, and counts that down.
class LossyLink final : public CanLink {
 public:
  LossyLink(std::unique_ptr<CanLink> link, std::atomic<int>& to_lose)
      : link_(std::move(link)), to_lose_(to_lose) {}
  void send(const CanFrame& frame) override { link_->send(frame); }
  bool receive(CanFrame& frame, int timeout_ms) override {
    while (link_->receive(frame, timeout_ms)) {
      if (to_lose_ == 0 || frame.id > 0x500) return true;
      --to_lose_;
    }
    return false;
  }
  void listen_to(std::span<const std::uint32_t> ids) override { link_->listen_to(ids); }
  std::string name() const override { return "lossy"; }

 private:
  std::unique_ptr<CanLink> link_;
  std::atomic<int>& to_lose_;
};

// The longest part in which the axis moves: of these two recordings the rest before the gap is shorter and
// longer than that.
TEST(LiveNode, OfARecordingWithALongGapTheLongestPartThatMovesBecomesTheLog) {
  for (const std::size_t rest : {200U, 6000U}) {
    Watched bench;
    std::atomic<int> to_lose{0};
    bench.live = std::make_unique<LiveNode>(bench.events, bench.talking, LiveNode::Target{"", 5, 500.0}, [&] {
      return std::make_unique<LossyLink>(bench.link(), to_lose);
    });
    const auto recorded = [&](std::size_t more) {
      const std::uint64_t begin = bench.live->end();
      return await([&] { return bench.live->end() > begin + more; });
    };
    ASSERT_TRUE(recorded(50));
    bench.live->start_recording();
    ASSERT_TRUE(recorded(rest));
    to_lose = 20;
    ASSERT_TRUE(await([&] { return to_lose == 0; }));
    bench.move(0.02);
    ASSERT_TRUE(recorded(1500));
    const Recording recording = bench.live->stop_recording();
    EXPECT_GT(recording.samples, 1500U);
    EXPECT_EQ(recording.lost, 0U);
    const Log log = test::read_recorded(recording.log);
    const auto [low, high] = std::minmax_element(log.position_m.begin(), log.position_m.end());
    EXPECT_NEAR(*high - *low, 0.02, 1e-3) << "a rest of " << rest << " samples is the log";
    EXPECT_NE(bench.live->to_json().at("notice").get<std::string>().find("The stream had gaps"),
              std::string::npos);
  }
}

TEST(LiveNode, TheControllerIsAsItWasWhenItIsLeft) {
  Watched bench;
  const auto objects = [&] {
    const auto cable = bench.link();
    SdoClient drive(*cable, 5);
    std::vector<std::uint32_t> values;
    for (const auto& [index, sub] : std::vector<std::pair<std::uint16_t, std::uint8_t>>{{0x1005, 0},
                                                                                        {0x1006, 0},
                                                                                        {0x1802, 1},
                                                                                        {0x1802, 2},
                                                                                        {0x1803, 1},
                                                                                        {0x1A03, 0},
                                                                                        {0x1A03, 1},
                                                                                        {0x1A03, 2}}) {
      values.push_back(drive.read(index, sub));
    }
    return values;
  };
  const auto before = objects();
  bench.watch();
  {
    const std::lock_guard lock(bench.talking);
    EXPECT_NE(objects(), before);
  }
  bench.live.reset();
  EXPECT_EQ(objects(), before);
}

json happened(const LiveNode& live) {
  return live.to_json().at("happened");
}

/// The newest entry that contains `words`; how many are newer. -1: none.
int place_of(const json& entries, const std::string& words) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].at("what").get<std::string>().find(words) != std::string::npos) return static_cast<int>(i);
  }
  return -1;
}

TEST(LiveNode, StateAndModeAreToldAsTheyChange) {
  Watched bench;
  bench.watch();
  EXPECT_EQ(bench.live->to_json().at("drive").at("state"), "switch on disabled");
  EXPECT_EQ(bench.live->to_json().at("drive").at("error"), "");
  EXPECT_TRUE(bench.live->to_json().at("emergency").is_null());
  const auto cable = bench.link();
  SdoClient drive(*cable, 5, &bench.talking);
  {
    DrivenAxis axis(drive);
    ASSERT_TRUE(await([&] { return bench.live->to_json().at("drive").at("state") == "operation enabled"; }));
    EXPECT_EQ(bench.live->to_json().at("drive").at("mode"), "profile position");
  }
  ASSERT_TRUE(await([&] { return bench.live->to_json().at("drive").at("state") == "ready to switch on"; }));
  const json seen = happened(*bench.live);
  const int enabled = place_of(seen, "operation enabled");
  ASSERT_GE(enabled, 0) << seen;
  EXPECT_LT(place_of(seen, "ready to switch on"), enabled) << "newest first";
  EXPECT_GT(place_of(seen, "connected"), enabled);
}

// A following error of 10 um is less than a move without a friction model has.
TEST(LiveNode, AFaultIsToldByItsEmergencyInPlainWords) {
  Watched bench;
  bench.watch();
  const auto cable = bench.link();
  SdoClient drive(*cable, 5, &bench.talking);
  drive.write_real(0x2000, 0x0F, 1e-5);  // the following error at which it stops
  drive.write(0x2140, 3, drive.read(0x2140, 1), 4);
  try {
    move_to_and_fro(drive, 0.1, 1, kQuiet);
  } catch (const UsageError&) {  // it is disabled on the way
  }
  ASSERT_TRUE(await([&] { return !bench.live->to_json().at("emergency").is_null(); }))
      << happened(*bench.live);
  const json emergency = bench.live->to_json().at("emergency");
  EXPECT_EQ(emergency.at("code"), "8611h");
  EXPECT_EQ(emergency.at("words"), error_words(0x8611));
  EXPECT_FALSE(emergency.at("earlier"));
  EXPECT_GE(place_of(happened(*bench.live), "EMCY 8611h"), 0);
  ASSERT_TRUE(await([&] { return bench.live->to_json().at("drive").at("error") == "8611h"; }));
  // Reset: the error goes, what it was stays to be read.
  drive.write(0x6040, 0, 0x80, 2);
  ASSERT_TRUE(
      await([&] { return bench.live->to_json().at("drive").at("error").get<std::string>().empty(); }));
  EXPECT_EQ(bench.live->to_json().at("emergency").at("code"), "8611h");
  EXPECT_GE(place_of(happened(*bench.live), "EMCY 0000h"), 0) << happened(*bench.live);
}

TEST(LiveNode, ADriveThatStartsAnewIsThereAgain) {
  Watched bench;
  bench.watch();
  const auto cable = bench.link();
  SdoClient drive(*cable, 5, &bench.talking);
  drive.nmt(0x81);
  ASSERT_TRUE(await([&] { return place_of(happened(*bench.live), "connected again") >= 0; }));
  const json seen = happened(*bench.live);
  EXPECT_EQ(place_of(seen, "lost: node 5"), place_of(seen, "connected again") + 1) << seen;
  const std::uint64_t end = bench.live->end();
  ASSERT_TRUE(await([&] { return bench.live->end() > end + 100; })) << "it streams again";
  const json times = bench.live->since(0).at("time_s");
  for (std::size_t i = 1; i < times.size(); ++i)
    ASSERT_GT(times[i].get<double>(), times[i - 1].get<double>()) << "time goes on";
}

/// A link that carries nothing while `cut`.
class CutLink final : public CanLink {
 public:
  CutLink(std::unique_ptr<CanLink> link, const std::atomic<bool>& cut) : link_(std::move(link)), cut_(cut) {}
  void send(const CanFrame& frame) override {
    if (!cut_) link_->send(frame);
  }
  bool receive(CanFrame& frame, int timeout_ms) override {
    if (!cut_) return link_->receive(frame, timeout_ms);
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    return false;
  }
  void listen_to(std::span<const std::uint32_t> ids) override { link_->listen_to(ids); }
  std::string name() const override { return "cut"; }

 private:
  std::unique_ptr<CanLink> link_;
  const std::atomic<bool>& cut_;
};

TEST(LiveNode, AfterACutCableItIsThereAgainAndIsLeftAsItWas) {
  Watched bench;
  std::atomic<bool> cut{false};
  const auto sync = [&] {
    const auto cable = bench.link();
    SdoClient drive(*cable, 5, &bench.talking);
    return std::pair(drive.read(0x1005, 0), drive.read(0x1A03, 1));
  };
  const auto before = sync();
  bench.live = std::make_unique<LiveNode>(bench.events, bench.talking, LiveNode::Target{"", 5, 500.0},
                                          [&] { return std::make_unique<CutLink>(bench.link(), cut); });
  ASSERT_TRUE(await([&] { return bench.live->end() > 50; }));
  cut = true;
  ASSERT_TRUE(await([&] { return bench.live->to_json().at("state") == "lost"; }));
  EXPECT_NE(sync(), before) << "nobody could restore it";
  cut = false;
  ASSERT_TRUE(await([&] { return bench.live->to_json().at("state") == "live"; }));
  EXPECT_GE(place_of(happened(*bench.live), "connected again"), 0);
  bench.live.reset();
  EXPECT_EQ(sync(), before);
}

TEST(DriveWords, EveryFaultOfTheFirmwareHasSome) {
  for (std::size_t i = 1; i < kFaultCount; ++i) {
    const std::uint16_t code = error_code(static_cast<Fault>(i));
    EXPECT_NE(error_words(code), "unknown to this program") << std::hex << code;
  }
  EXPECT_NE(error_words(0xFF01).find("hunts"), std::string::npos);
  EXPECT_EQ(error_words(0xFF02), "unknown to this program");
}

TEST(DriveWords, HuntingNamesWhatIsLowered) {
  const auto names = [](HuntingState state, HuntingCause cause, const char* what) {
    return hunting_words(static_cast<std::uint32_t>(state), static_cast<std::uint32_t>(cause)).find(what) !=
           std::string::npos;
  };
  EXPECT_TRUE(names(HuntingState::kLowered, HuntingCause::kFriction, "friction compensation"));
  EXPECT_TRUE(names(HuntingState::kLowered, HuntingCause::kDisturbanceObserver, "disturbance observer"));
  EXPECT_TRUE(names(HuntingState::kGoesOn, HuntingCause::kElsewhere, "not by its compensation"));
  EXPECT_TRUE(names(HuntingState::kTrying, HuntingCause::kNone, "being tried"));
  EXPECT_TRUE(names(HuntingState::kWatching, HuntingCause::kEnded, "ended by itself"));
  EXPECT_TRUE(names(HuntingState::kWatching, HuntingCause::kNone, "none"));
  EXPECT_EQ(error_words(0x1234), "unknown to this program");
}

TEST(LiveNode, WhatGoesWrongIsSaid) {
  Events events;
  std::mutex talking;
  LiveNode none(events, talking, {"can7", 5, 500.0},
                []() -> std::unique_ptr<CanLink> { throw UsageError("can7: there is no such interface"); });
  ASSERT_TRUE(await([&] { return none.to_json().at("state") == "lost"; }));
  EXPECT_EQ(none.to_json().at("error"), "can7: there is no such interface");
  EXPECT_THROW(none.start_recording(), UsageError);
  EXPECT_TRUE(none.since(0).at("time_s").empty());

  SimulatedController controller(kAxis);
  LiveNode other(events, talking, {"", 9, 500.0},
                 [&] { return controller.connect(SimulatedController::Wait::as_fast_as_possible); });
  ASSERT_TRUE(await([&] { return other.to_json().at("state") == "lost"; }));
  EXPECT_NE(other.to_json().at("error").get<std::string>().find("node 9 does not answer"), std::string::npos);
}

TEST(LiveNode, AnAxisInAUnitOfItsOwnIsNotMoved) {
  SimulatedController controller(kAxis);
  const auto cable = controller.connect(SimulatedController::Wait::as_fast_as_possible);
  SdoClient drive(*cable, 5);
  drive.write(0x608F, 1, 200, 4);
  EXPECT_THROW(move_to_and_fro(drive, 0.01, 1, kQuiet), UsageError);
  EXPECT_EQ(drive.read(0x6041, 0) & 0x6FU, 0x40U & 0x6FU) << "and is not enabled";
}

}  // namespace
}  // namespace slipstack::workbench
