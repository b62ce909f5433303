// SPDX-License-Identifier: Apache-2.0
// slipstack-sim as the user meets it: files, exit status, one line on the terminal.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status;
  std::string errors;
};

class Program : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              (std::string("slipstack_sim_") + info->name() + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& file) const { return (folder_ / file).string(); }
  std::string read(const std::string& file) const {
    std::ifstream in(path(file), std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  Outcome run(const std::string& arguments) const {
    const std::string command =
        std::string(SLIPSTACK_SIM_PROGRAM) + " " + arguments + " >" + path("stdout") + " 2>" + path("stderr");
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), read("stderr")};
  }

  fs::path folder_;
};

TEST_F(Program, WritesALogThatFollowsTheContract) {
  const Outcome outcome = run("log --setup pick_and_place --seed 5 --seconds 10 --out " + path("a.csv") +
                              " --truth " + path("a.json"));
  ASSERT_EQ(outcome.status, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  std::istringstream csv(read("a.csv"));
  std::string line;
  std::string header;
  int comments = 0;
  while (std::getline(csv, line) && line.rfind("# ", 0) == 0) {
    EXPECT_NE(line.find(": "), std::string::npos);
    ++comments;
  }
  EXPECT_GE(comments, 4);
  EXPECT_EQ(line, "time_s,position_m,force_N");
  double last = -1.0;
  int rows = 0;
  while (std::getline(csv, line)) {
    double t = 0.0;
    double x = 0.0;
    double f = 0.0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &t, &x, &f), 3) << line;
    ASSERT_NEAR(t - last, rows == 0 ? 1.0 : 5e-4, 1e-9);
    last = t;
    ++rows;
  }
  EXPECT_GT(rows, 12000);
  const std::string truth = read("a.json");
  for (const char* key : {"\"effects\"", "\"formulas\"", "\"parameters\"", "\"noise_N\"", "\"encoder_m\"",
                          "\"effect_rms_N\"", "\"force_rms_N\""}) {
    EXPECT_NE(truth.find(key), std::string::npos) << key;
  }
}

TEST_F(Program, TellsWhatTheRecordingAddsToTheForce) {
  const std::string call = "log --setup random --seed 4 --seconds 10 --out " + path("a.csv") + " --truth " +
                           path("a.json") + " --outside ";
  ASSERT_EQ(run(call + "ring").status, 0);
  const std::string of_ring = read("a.json");
  for (const char* key : {"\"outside\": \"ring\"", "\"frequency_Hz\"", "\"damping_ratio\"", "\"rms_N\"",
                          "\"rms_over_noise\"", "\"none\""}) {
    EXPECT_NE(of_ring.find(key), std::string::npos) << key;
  }
  ASSERT_EQ(run(call + "force_filter --effects viscous").status, 0);
  const std::string of_filter = read("a.json");
  for (const char* key : {"\"outside\": \"force_filter\"", "\"cut_Hz\"", "\"half_amplitude_Hz\"", "\"order\"",
                          "\"zero_phase\"", "\"viscous\""}) {
    EXPECT_NE(of_filter.find(key), std::string::npos) << key;
  }
}

TEST_F(Program, RepeatsItself) {
  for (const std::string& mode : {std::string(), std::string(" --closed-loop")}) {
    const std::string call = "log --setup random --seed 11 --seconds 8" + mode + " --out ";
    ASSERT_EQ(run(call + path("a.csv") + " --truth " + path("a.json")).status, 0);
    ASSERT_EQ(run(call + path("b.csv") + " --truth " + path("b.json")).status, 0);
    EXPECT_EQ(read("a.csv"), read("b.csv"));
    EXPECT_EQ(read("a.json"), read("b.json"));
    EXPECT_GT(read("a.csv").size(), 10000U);
  }
}

TEST_F(Program, WrongUseIsOneLineAndStatusTwo) {
  const std::string out = " --out " + path("x.csv");
  for (const std::string& arguments :
       {std::string(), std::string("log"), std::string("dance"), "log --setup lathe" + out,
        "log --effects magic" + out, "log --effects inertia" + out, "log --effects viscous,," + out,
        "log --outside moon" + out, "log --seconds 3" + out, "log --seconds 1e9" + out,
        "log --rate 0.5" + out, "log --rate abc" + out, "log --rate nan" + out, "log --strength -2" + out,
        "log --seed -1" + out, "log --frobnicate" + out, std::string("log --out /nowhere/x.csv")}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << arguments << ": " << outcome.errors;
    EXPECT_FALSE(fs::exists(path("x.csv"))) << arguments;
  }
}

}  // namespace
