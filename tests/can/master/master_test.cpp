// SPDX-License-Identifier: Apache-2.0
// The commands' master against the node, in one process: deploy, record, status, and what goes wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "tests/can/master/desk.h"
#include "workbench/can/commands/master.h"
#include "workbench/can/drive/drive_stream.h"
#include "workbench/console/output.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {
namespace {

Model model_of_mass(double mass_kg) {
  Model model;
  for (const EffectDescription& effect : catalogue()) {
    const std::string id = effect.text.id;
    if (id != "inertia" && id != "viscous") continue;
    Term term;
    term.effect = &effect;
    term.gains = {id == "inertia" ? mass_kg : 12.0};
    model.terms.push_back(term);
  }
  model.target_terms = model.terms;
  return model;
}

TEST(Deploy, StagesAppliesAndStores) {
  Desk desk;
  const Model model = model_of_mass(33.5);
  const std::string text = deploy_model(*desk.client, model, "m.toml", true, kNoiseless);
  EXPECT_NE(text.find("read back the same"), std::string::npos) << text;
  EXPECT_EQ(desk.drive->controller().parameters().hash, target_hash(model));
  EXPECT_FLOAT_EQ(desk.drive->controller().parameters().mass_kg, 33.5F);
  desk.power_on();
  EXPECT_EQ(desk.drive->controller().parameters().hash, target_hash(model)) << "stored";
}

// What an effect of the user's own is on the controller: its table arrives, is stored, and acts.
TEST(Deploy, ATableOfAnOwnEffect) {
  Desk desk;
  Model model = model_of_mass(33.5);
  Term table;
  table.effect = &controller_table();
  table.shapes = {-1.0, 320.0, 0.0, 0.0, 0.0};  // over all of the rail
  table.gains.assign(kUserTablePoints, 2.5);
  model.target_terms.push_back(table);
  deploy_model(*desk.client, model, "m.toml", true, kNoiseless);
  EXPECT_EQ(desk.drive->controller().parameters().hash, target_hash(model));
  EXPECT_NE(target_hash(model), target_hash(model_of_mass(33.5)));
  desk.power_on();
  EXPECT_EQ(desk.drive->controller().parameters().hash, target_hash(model)) << "stored";
  EXPECT_EQ(desk.drive->controller().friction().by_effect_N.back(), 2.5F);
}

TEST(Deploy, NoStoreIsGoneWithTheNextStart) {
  Desk desk;
  const std::uint32_t before = desk.drive->controller().parameters().hash;
  deploy_model(*desk.client, model_of_mass(20.0), "m.toml", false, kNoiseless);
  EXPECT_NE(desk.drive->controller().parameters().hash, before);
  desk.power_on();
  EXPECT_EQ(desk.drive->controller().parameters().hash, before);
}

// The cable is pulled at every frame in turn: the old model runs, or the new one, and a second try succeeds.
TEST(Deploy, ACableThatIsPulledNeverLeavesAMixture) {
  const Model model = model_of_mass(33.5);
  bool whole = false;
  for (int frames = 0; !whole; ++frames) {
    Desk desk;
    const std::uint32_t before = desk.drive->controller().parameters().hash;
    int left = frames;
    desk.link->meddle = [&](const CanFrame& frame) {
      if (frame.id == 0x585 && left-- == 0) desk.link->cut = true;
      return false;
    };
    try {
      deploy_model(*desk.client, model, "m.toml", true, kNoiseless);
      whole = !desk.link->cut;
    } catch (const UsageError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
    const std::uint32_t after = desk.drive->controller().parameters().hash;
    ASSERT_TRUE(after == before || after == target_hash(model)) << frames;
    desk.link->cut = false;
    desk.link->meddle = nullptr;
    for (int i = 0; i < 12000; ++i) desk.drive->step();  // the broken transfer times out
    if (frames % 10 == 0) {
      deploy_model(*desk.client, model, "m.toml", true, kNoiseless);
      ASSERT_EQ(desk.drive->controller().parameters().hash, target_hash(model)) << frames;
    }
    ASSERT_LT(frames, 500);
  }
}

// `record` and `status` right after `node &`: frames before the node listens are lost.
TEST(Client, WaitsForANodeThatHasJustBeenStarted) {
  for (const double start_s : {0.0, 0.4, 1.7, 2.4}) {
    Desk desk;
    desk.link->cut = true;
    desk.link->each_tick = [&](std::uint64_t tick) {
      if (1e-4 * static_cast<double>(tick) >= start_s) desk.link->cut = false;
    };
    EXPECT_NO_THROW(desk.client->await_node()) << start_s;
    EXPECT_EQ(desk.client->read(0x1000, 0), 0x00020192U) << start_s;
    EXPECT_NE(drive_status(*desk.client).find("switch on disabled"), std::string::npos);
  }
  Desk desk;
  desk.link->cut = true;
  try {
    desk.client->await_node();
    FAIL() << "nobody is there";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("is it running"), std::string::npos) << error.what();
  }
}

// A new node on the host is commissioned in its flash, so that a reset finds what it ran with.
TEST(SimulatedDrive, IsCommissionedInItsFlash) {
  Desk desk;
  const double resolution_m = desk.client->read_real(0x2000, 1);
  const std::uint32_t hash = desk.client->read(0x2140, 2);
  ASSERT_NE(hash, 0U);
  desk.client->nmt(0x81);
  for (int i = 0; i < 100; ++i) desk.drive->step();
  EXPECT_EQ(desk.client->read_real(0x2000, 1), resolution_m);
  EXPECT_EQ(desk.client->read(0x2140, 2), hash);
  desk.power_on();
  EXPECT_EQ(desk.client->read(0x2140, 2), hash);
  desk.enable();
  EXPECT_EQ(desk.client->read(0x6041, 0) & 0x6F, 0x27U);
}

TEST(Deploy, AnEnabledDriveRefuses) {
  Desk desk;
  desk.enable();
  const std::uint32_t before = desk.drive->controller().parameters().hash;
  EXPECT_THROW(deploy_model(*desk.client, model_of_mass(33.5), "m.toml", true, kNoiseless), UsageError);
  EXPECT_EQ(desk.drive->controller().parameters().hash, before);
}

TEST(Deploy, AModelOutOfBoundsIsRefusedBeforeAnythingIsSent) {
  Desk desk;
  Model model = model_of_mass(33.5);
  model.target_terms[0].gains[0] = -1.0;
  EXPECT_THROW(deploy_model(*desk.client, model, "m.toml", true, kNoiseless), UsageError);
  EXPECT_THROW(SdoClient(*desk.link, 6).read(0x1000, 0), UsageError) << "nobody there";
}

/// A long move under way: what a log is recorded of.
void set_moving(Desk& desk) {
  desk.client->write(0x6081, 0, 20000, 4);
  desk.enable();
  desk.client->write(0x607A, 0, 60000, 4);
  desk.client->write(0x6040, 0, 0x5F, 2);
}

std::filesystem::path written(const std::string& text) {
  std::filesystem::path path = std::filesystem::path(::testing::TempDir()) /
                               ("slipstack_record_" + std::to_string(::getpid()) + ".csv");
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::vector<std::array<double, 3>> rows_of(const std::string& text) {
  std::vector<std::array<double, 3>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::array<double, 3> row{};
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &row[0], &row[1], &row[2]) == 3) rows.push_back(row);
  }
  return rows;
}

TEST(Record, AStreamIsUniformAndPutsEverythingBack) {
  Desk desk;
  const std::uint32_t cob = desk.client->read(0x1802, 1);
  const std::uint32_t sync = desk.client->read(0x1005, 0);
  set_moving(desk);
  const Recording recording = record_stream(*desk.client, 2.0, 1000.0, kNoiseless);
  EXPECT_EQ(recording.samples, 2000U);
  EXPECT_EQ(recording.lost, 0U);
  EXPECT_FALSE(recording.arrival_spread_s) << "this bus gives no time stamps";
  EXPECT_EQ(recording.log.find("irregular"), std::string::npos);
  const auto rows = rows_of(recording.log);
  ASSERT_EQ(rows.size(), 2000U);
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_NEAR(rows[i][0], 1e-3 * static_cast<double>(i), 1e-9);
  EXPECT_EQ(desk.client->read(0x1802, 1), cob);
  EXPECT_EQ(desk.client->read(0x1005, 0), sync);
  EXPECT_EQ(desk.client->read(0x1006, 0), 0U);
  const auto path = written(recording.log);
  EXPECT_NO_THROW(read_log(path)) << "the log that diagnose reads";
  std::filesystem::remove(path);
}

TEST(Record, AStreamWithTheObserverShowsWhatTheDriveHoldsAndPutsEverythingBack) {
  Desk desk;
  // As a user has set it: TPDO 4 with another mapping, and off.
  SdoClient& client = *desk.client;
  client.write(0x1803, 1, client.read(0x1803, 1) | 0x80000000U, 4);
  client.write(0x1A03, 0, 0, 1);
  client.write(0x1A03, 1, 0x60410010U, 4);
  client.write(0x1A03, 0, 1, 1);
  using At = std::pair<std::uint16_t, std::uint8_t>;
  const std::vector<At> changed = {{0x1005, 0}, {0x1006, 0}, {0x1802, 1}, {0x1802, 2}, {0x1803, 1},
                                   {0x1803, 2}, {0x1A03, 0}, {0x1A03, 1}, {0x1A03, 2}};
  std::vector<std::uint32_t> before;
  before.reserve(changed.size());
  for (const auto& [index, sub] : changed) before.push_back(client.read(index, sub));
  set_moving(desk);
  double largest_m = 0.0;
  double largest_N = 0.0;
  {
    DriveStream stream(client, 500.0, DriveStream::With::observer);
    EXPECT_GT(stream.axis().mass_kg, 1.0);
    std::int64_t last = 0;
    for (int i = 0; i < 500; ++i) {
      const auto sample = stream.next(100);
      ASSERT_TRUE(sample) << i;
      const std::int64_t step = i == 0 ? 20 : sample->tick - last;
      ASSERT_EQ(step, 20) << i;
      last = sample->tick;
      largest_m = std::max(largest_m, std::abs(static_cast<double>(sample->error_m)));
      largest_N = std::max(largest_N, std::abs(static_cast<double>(sample->residual_N)));
    }
  }
  // A model of the mass alone: friction of some newtons is left, and the position error is one of
  // micrometres.
  EXPECT_GT(largest_N, 1.0);
  EXPECT_LT(largest_N, 300.0);
  EXPECT_GT(largest_m, 1e-6);
  EXPECT_LT(largest_m, 1e-3);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    EXPECT_EQ(client.read(changed[i].first, changed[i].second), before[i])
        << std::hex << changed[i].first << ':' << int(changed[i].second);
  }
}

TEST(Record, ArrivalIsTheSpreadOfTheStampsAgainstTheDrivesClock) {
  Desk desk;
  desk.link->stamped = true;
  int number = 0;
  desk.link->meddle = [&](const CanFrame& frame) {
    if (frame.id == 0x385) desk.link->late_s = ++number % 7 == 3 ? 5e-3 : 0.0;
    return false;
  };
  set_moving(desk);
  const Recording recording = record_stream(*desk.client, 0.5, 1000.0, kNoiseless);
  ASSERT_TRUE(recording.arrival_spread_s);
  EXPECT_NEAR(*recording.arrival_spread_s, 5e-3, 2e-4);  // and the tick in which a frame is sent
}

TEST(Record, LostFramesAreCountedAndMarked) {
  Desk desk;
  int number = 0;
  desk.link->meddle = [&](const CanFrame& frame) {
    return frame.id == 0x385 && (++number % 100 == 50 || number % 100 == 51);
  };
  set_moving(desk);
  const Recording recording = record_stream(*desk.client, 1.0, 1000.0, kNoiseless);
  EXPECT_EQ(recording.samples, 1000U);
  EXPECT_EQ(recording.lost, 20U);
  EXPECT_NE(recording.log.find("# lost_samples: 20\n"), std::string::npos);
  EXPECT_NE(recording.log.find("# sampling: irregular\n"), std::string::npos);
  const auto path = written(recording.log);
  EXPECT_NO_THROW(read_log(path));
  std::filesystem::remove(path);
}

TEST(Record, TheTraceHoldsEveryTick) {
  Desk desk;
  const Recording recording = record_trace(*desk.client, 1, kNoiseless);
  const auto rows = rows_of(recording.log);
  ASSERT_EQ(rows.size(), 4096U);
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_NEAR(rows[i][0], 1e-4 * static_cast<double>(i), 1e-9);
}

TEST(Record, ADriveThatGoesSilentIsOneLine) {
  Desk desk;
  int number = 0;
  desk.link->meddle = [&](const CanFrame& frame) {
    if (frame.id == 0x385 && ++number == 100) desk.link->cut = true;
    return false;
  };
  try {
    record_stream(*desk.client, 1.0, 1000.0, kNoiseless);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("stopped after"), std::string::npos) << error.what();
  }
}

// A busy machine loses frames: any of a block, its last one too, which nothing follows that would show it.
TEST(Client, AnUploadOutlivesLostSegments) {
  Desk desk;
  const auto whole = desk.client->upload(0x2141, 0);
  ASSERT_GT(whole.size(), 2U * 7U);
  const auto segments = static_cast<int>((whole.size() + 6) / 7);
  for (const int first : {0, 1, segments / 2, segments - 2, segments - 1, segments}) {  // the last: the end
    for (const int lost : {1, 2, 8}) {
      int number = -1;
      int held_back = 0;
      desk.link->meddle = [&](const CanFrame& frame) {
        if (frame.id != 0x585 || (frame.data[0] & 0x7F) == 0 || frame.data[0] == 0xC6) return false;
        ++number;
        const bool now = number >= first && number < first + lost;
        held_back += now ? 1 : 0;
        return now;
      };
      EXPECT_EQ(desk.client->upload(0x2141, 0), whole) << "without " << lost << " from " << first;
      EXPECT_GT(held_back, 0);
      desk.link->meddle = nullptr;
    }
  }
}

// A master that was held up for longer than the server waits, or whose data came over wrong, asks again.
TEST(Client, AnUploadThatTimedOutOrIsWrongIsAskedForAgain) {
  Desk desk;
  const auto whole = desk.client->upload(0x2141, 0);
  int aborts = 0;
  bool held_up = false;
  desk.link->meddle = [&](const CanFrame& frame) {
    if (frame.id == 0x585 && frame.data[0] == 0x80) ++aborts;
    if (frame.id == 0x585 && frame.data[0] == 0x01 && !held_up) {
      held_up = true;
      for (int tick = 0; tick < 11000; ++tick) desk.drive->step();
    }
    return false;
  };
  EXPECT_EQ(desk.client->upload(0x2141, 0), whole);
  EXPECT_TRUE(held_up);
  EXPECT_GE(aborts, 1);

  int uploads = 0;
  desk.link->meddle = [&](const CanFrame& frame) {
    uploads += frame.id == 0x585 && frame.data[0] == 0xC6 ? 1 : 0;
    return false;
  };
  desk.link->twist = [&](CanFrame& frame) {
    if (frame.id == 0x585 && frame.data[0] == 0x02 && uploads == 1) frame.data[3] ^= 0x10U;
  };
  EXPECT_EQ(desk.client->upload(0x2141, 0), whole);
  EXPECT_EQ(uploads, 2);
  desk.link->twist = [&](CanFrame& frame) {
    if (frame.id == 0x585 && frame.data[0] == 0x02) frame.data[3] ^= 0x10U;
  };
  try {
    desk.client->upload(0x2141, 0);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("checksum of 2141h is wrong"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(uploads, 5);
}

/// A node that gives the same answer to everything.
class StubbornLink final : public CanLink {
 public:
  explicit StubbornLink(const std::array<std::uint8_t, 8>& says) { frame_.data = says; }
  void send(const CanFrame& frame) override {
    ++sent;
    for (std::size_t i = 1; i < 4; ++i) frame_.data[i] = echo ? frame.data[i] : frame_.data[i];
    waiting_ = true;
  }
  bool receive(CanFrame& frame, int timeout_ms) override {
    if (timeout_ms == 0 || !(waiting_ || again)) return false;
    waiting_ = false;
    frame_.id = 0x585;
    frame_.length = 8;
    frame = frame_;
    return true;
  }
  std::string name() const override { return "stubborn"; }
  bool echo = true;
  bool again = false;
  int sent = 0;

 private:
  CanFrame frame_;
  bool waiting_ = false;
};

// What another master, or a broken node, says is not taken for an answer, and no transfer goes on for ever.
TEST(Client, WrongAnswersAreToldAndEnd) {
  const auto refusal = [](StubbornLink link, const std::function<void(SdoClient&)>& act) -> std::string {
    SdoClient client(link, 5);
    try {
      act(client);
    } catch (const UsageError& error) {
      EXPECT_LT(link.sent, 5000);
      return error.what();
    }
    return "nothing";
  };
  const std::string wrong = "two masters";
  const auto write = [](SdoClient& client) { client.write(0x6060, 0, 1, 1); };
  const auto upload = [](SdoClient& client) { client.upload(0x2310, 0); };
  const auto download = [](SdoClient& client) {
    client.download(0x2141, 0, std::vector<std::uint8_t>(5000, 1));
  };
  EXPECT_EQ(refusal(StubbornLink({0x60}), write), "nothing") << "taken";
  EXPECT_NE(refusal(StubbornLink({0x43}), write).find(wrong), std::string::npos) << "an upload's answer";
  StubbornLink of_another({0x60, 0x17, 0x10, 0});
  of_another.echo = false;
  EXPECT_NE(refusal(of_another, write).find(wrong), std::string::npos) << "another object's";
  EXPECT_NE(refusal(StubbornLink({0xC6, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF}), upload).find(wrong),
            std::string::npos)
      << "4 GiB";
  EXPECT_NE(refusal(StubbornLink({0xC6, 0, 0, 0, 0, 0, 0, 0}), upload).find(wrong), std::string::npos)
      << "nothing";
  EXPECT_NE(refusal(StubbornLink({0xA4, 0, 0, 0, 0, 0, 0, 0}), download).find(wrong), std::string::npos)
      << "blocks of no segment";
  EXPECT_NE(refusal(StubbornLink({0xA4, 0, 0, 0, 0x80, 0, 0, 0}), download).find(wrong), std::string::npos)
      << "blocks of 128 segments";
  EXPECT_NE(refusal(StubbornLink({0xA4, 0, 0, 0, 0x7F, 0, 0, 0}), download).find(wrong), std::string::npos)
      << "never an acknowledgement";
}

TEST(Status, SaysWhatTheDriveSays) {
  Desk desk;
  const std::string text = drive_status(*desk.client);
  EXPECT_NE(text.find("switch on disabled"), std::string::npos) << text;
  EXPECT_NE(text.find("lock       off"), std::string::npos);
  EXPECT_NE(text.find("hunting    none\n"), std::string::npos);
}

// A node whose firmware is from before 2202h refuses it: object does not exist (CiA 301 table 22). Any other
// refusal, and no answer, are errors.
TEST(Status, OfANodeWithoutAWatchOfHuntingShowsTheRest) {
  const auto status = [](std::uint32_t code) {
    Desk desk;
    desk.link->twist = [code](CanFrame& frame) {
      if (frame.id != 0x585 || frame.data[1] != 0x02 || frame.data[2] != 0x22) return;
      frame.data[0] = 0x80;
      for (std::size_t i = 0; i < 4; ++i) frame.data[4 + i] = static_cast<std::uint8_t>(code >> (8 * i));
    };
    return drive_status(*desk.client);
  };
  const std::string text = status(0x06020000);
  EXPECT_NE(text.find("\nhunting    not watched: this firmware is older than the watch of hunting\nmodel "),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("lock       off"), std::string::npos) << text;
  EXPECT_THROW(status(0x06090011), SdoAbort) << "the sub-index does not exist";
  EXPECT_THROW(status(0x08000000), SdoAbort) << "general error";

  Desk silent;
  silent.link->meddle = [](const CanFrame& frame) {
    return frame.id == 0x585 && frame.data[1] == 0x02 && frame.data[2] == 0x22;
  };
  EXPECT_THROW(drive_status(*silent.client), UsageError) << "no answer";
}

}  // namespace
}  // namespace slipstack::workbench
