// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/session/session.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "workbench/base/atomic_write.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/serve/session/plain_file.h"
#include "workbench/serve/session/workspace.h"

namespace slipstack::workbench {
namespace {

namespace fs = std::filesystem;

class SessionTest : public testing::Test {
 protected:
  SessionTest() {
    std::string pattern = (fs::temp_directory_path() / "slipstack-session-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~SessionTest() override { fs::remove_all(folder_); }
  SessionTest(const SessionTest&) = delete;
  SessionTest& operator=(const SessionTest&) = delete;

  static Model model(double error_N) {
    Model model;
    const EffectDescription& inertia = effect_with_role(Role::inertia);
    Term term;
    term.effect = &inertia;
    for (const ShapeSpec& shape : inertia.shapes) term.shapes.push_back(static_cast<double>(shape.lower));
    term.gains.assign(static_cast<std::size_t>(inertia.gain_count), 10.0);
    term.lower.assign(term.gains.size(), 0.0);
    term.upper.assign(term.gains.size(), 1e3);
    model.terms = model.target_terms = {term};
    model.source.holdout_rmse_N = error_N;
    return model;
  }
  fs::path folder_;
};

// What is published of a rotary axis has other names; the session reads its own files again, and so does the
// page.
TEST_F(SessionTest, OfARotaryAxisIsThereAgain) {
  forget_axis();
  use_axis({AxisKind::rotary, AngleUnit::radian}, "joint.csv");
  {
    Session session(folder_);
    const int first = session.add(0, "fitted", model(3.0), 0.0);
    session.add(first, "more", model(2.0), 3.0);
    session.set_diagnosis(first, {{"candidates", {{{"effect", "viscous"}, {"holdout_rmse_N", 2.0}}}}});
  }
  forget_axis();
  Session again(folder_);
  ASSERT_EQ(again.versions().size(), 2U);
  EXPECT_EQ(again.versions().back().before_N, 3.0);
  EXPECT_EQ(again.versions().back().after_N, 2.0);
  const auto diagnosis = again.diagnosis(again.versions().front().id);
  ASSERT_TRUE(diagnosis.has_value());
  EXPECT_EQ(diagnosis->at("candidates").at(0).at("holdout_rmse_N"), 2.0);
}

TEST_F(SessionTest, UndoRedoAndBranches) {
  Session session(folder_);
  const int first = session.add(0, "fitted", model(3.0), 0.0);
  const int second = session.add(first, "more", model(2.0), 3.0);
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.current()->id, first);
  EXPECT_FALSE(session.undo());
  EXPECT_TRUE(session.redo());
  EXPECT_EQ(session.current()->id, second);
  session.select(first);
  const int branch = session.add(first, "other", model(1.0), 3.0);
  EXPECT_EQ(session.version(branch).parent, first);
  EXPECT_EQ(session.versions().size(), 3U);
  EXPECT_EQ(session.version(branch).after_N, 1.0);
  EXPECT_THROW(session.select(99), UsageError);

  const Session again(folder_);
  EXPECT_EQ(again.versions().size(), 3U);
  EXPECT_EQ(again.current()->id, branch);
  EXPECT_EQ(ids_of(again.model(second).terms), ids_of(session.model(second).terms));
}

// What a crash leaves between two files: a model that no list names, and temporary files.
TEST_F(SessionTest, OpensAfterACrash) {
  {
    Session session(folder_);
    session.add(0, "fitted", model(3.0), 0.0);
  }
  write_atomically(folder_ / "models" / "2.toml", to_toml(model(2.5)));
  std::ofstream(folder_ / "models" / ".3.toml.17.0") << "half a mo";
  std::ofstream(folder_ / ".session.json.17.0") << "{\"format\": ";
  Session session(folder_);
  ASSERT_EQ(session.versions().size(), 2U);
  EXPECT_EQ(session.version(2).after_N, 2.5);
  EXPECT_EQ(session.add(2, "next", model(1.0), 2.5), 3);
}

TEST_F(SessionTest, NeverLeavesItsFolder) {
  Session session(folder_);
  for (const char* name : {"../../etc/passwd", "/etc/passwd", "..", "...", "a/b\\c.csv", "", "\x01\x02"}) {
    EXPECT_TRUE(lies_in(folder_ / "logs", session.store_log(name, "x"))) << name;
  }
  std::ofstream(folder_ / "session.json")
      << R"({"format": "slipstack session 1", "logs": [], "current": 1, "versions": [{"id": 1, "parent": 0,
          "what": "", "date": "", "file": "../../../etc/passwd", "before_N": 0, "after_N": 0, "floor_N": 0,
          "effects": []}]})";
  EXPECT_THROW(Session{folder_}, InputError);
}

TEST_F(SessionTest, WritesWholeOrNothing) {
  const fs::path path = folder_ / "file";
  write_atomically(path, "one");
  EXPECT_EQ(read_whole(path, 100), "one");
  EXPECT_THROW(static_cast<void>(read_whole(path, 2)), InputError);
  EXPECT_THROW(write_atomically(folder_ / "no folder" / "file", "two"), UsageError);
  EXPECT_THROW(write_atomically("/dev/full/file", "two"), UsageError);
  EXPECT_EQ(read_whole(path, 100), "one");
}

TEST(Logs, OfDifferentRatesAreNamedRateByRate) {
  // The rates of one drive differ a little by the resolution of the times in a log.
  EXPECT_NO_THROW(require_one_rate({}));
  EXPECT_NO_THROW(require_one_rate({{"a.csv", 2000.0}, {"b.csv", 2000.1}}));
  try {
    require_one_rate({{"a.csv", 2000.0}, {"b.csv", 500.0}, {"c.csv", 2000.0}});
    FAIL() << "two rates were accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "the logs have different sampling rates (2000 Hz: a.csv, c.csv; 500 Hz: b.csv); close those of "
        "all rates but one, or resample them and open them again");
  }
}

}  // namespace
}  // namespace slipstack::workbench
