// SPDX-License-Identifier: Apache-2.0
// Diagnoses simulated logs whose hidden effect the diagnosis does not know, and counts how often it is
// correct.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>

#include "tests/bench/blind/summary.h"

namespace {

using namespace slipstack::bench;

struct Request {
  std::vector<std::string> kinds{"clean", "single",   "pair",  "triple", "line",
                                 "bump",  "backlash", "burst", "slip"};
  std::uint64_t first_seed = 1000;
  std::uint64_t count = 20;
  std::string results;
  std::string keep;
  bool check = false;
  bool every = false;
};

/// A folder for the logs; temporary and removed at the end, unless one is given.
class Folder {
 public:
  explicit Folder(const std::string& kept)
      : kept_(!kept.empty()),
        path_(kept_
                  ? std::filesystem::path(kept)
                  : std::filesystem::temp_directory_path() / fmt::format("slipstack-blind-{}", ::getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  /// Path of one log; the same for all unless logs are kept.
  std::filesystem::path log(const std::string& kind, std::uint64_t seed) const {
    return path_ / (kept_ ? fmt::format("{}_{}.csv", kind, seed) : "log.csv");
  }

 private:
  bool kept_;
  std::filesystem::path path_;
};

Kind kind_of(const std::string& name) {
  for (int k = 0; k <= static_cast<int>(Kind::slip); ++k) {
    if (name == name_of(static_cast<Kind>(k))) return static_cast<Kind>(k);
  }
  throw CLI::ValidationError("--kind", "unknown kind '" + name + "'");
}

/// Outcomes of an earlier run that was stopped: one JSON object per line.
std::map<std::pair<std::string, std::uint64_t>, Outcome> earlier(const std::string& path) {
  std::map<std::pair<std::string, std::uint64_t>, Outcome> known;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const Outcome outcome = outcome_from(nlohmann::json::parse(line));
    known[{name_of(outcome.kind), outcome.seed}] = outcome;
  }
  return known;
}

/// Exit status: 1 if --check finds a figure below its threshold, or --every a miss; else 0.
int run(const Request& request) {
  const Folder folder(request.keep);
  const auto known = request.results.empty() ? decltype(earlier("")){} : earlier(request.results);
  std::ofstream results;
  if (!request.results.empty()) results.open(request.results, std::ios::app);
  std::vector<Outcome> outcomes;
  for (const std::string& name : request.kinds) {
    for (std::uint64_t seed = request.first_seed; seed < request.first_seed + request.count; ++seed) {
      const auto done = known.find({name, seed});
      if (done != known.end()) {
        outcomes.push_back(done->second);
        continue;
      }
      // Every third axis is moved by a controller, with its control errors.
      outcomes.push_back(run_case(kind_of(name), seed, seed % 3 == 0, folder.log(name, seed)));
      fmt::print(stderr, "{}\n", line_of(outcomes.back()));
      if (results.is_open()) results << to_json(outcomes.back()).dump() << std::endl;
    }
  }
  fmt::print("{}", summary(outcomes));
  const std::vector<std::string> found = request.check ? shortfalls(outcomes) : std::vector<std::string>{};
  for (const std::string& shortfall : found) fmt::print("short: {}\n", shortfall);
  const bool missed = request.every && !std::all_of(outcomes.begin(), outcomes.end(),
                                                    [](const Outcome& one) { return one.right(); });
  return found.empty() && !missed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Blind benchmark of the diagnosis, on axes simulated by physics that it does not share");
  Request request;
  app.add_option("--kind", request.kinds, "clean, single, pair, triple, line, bump, backlash, burst, slip")
      ->delimiter(',');
  app.add_option("--first-seed", request.first_seed);
  app.add_option("--count", request.count, "logs of each kind");
  app.add_option("--results", request.results, "file of outcomes; a run that was stopped goes on from it");
  app.add_option("--keep", request.keep, "folder to keep the logs in");
  app.add_flag("--every", request.every, "status 1 when one log is diagnosed incorrectly");
  app.add_flag("--check", request.check,
               "status 1 when a share falls short of what every full test run must reach");
  try {
    app.parse(argc, argv);
    return run(request);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "blind_bench: {}\n", error.what());
    return 1;
  }
}
