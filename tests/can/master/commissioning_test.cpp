// SPDX-License-Identifier: Apache-2.0
// Runs the commissioning of docs/hardware.md as it is printed there, against the simulated drive, and
// compares what each command says. SLIPSTACK_WRITE_COMMISSIONING=1 writes today's answers into the page.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/can/master/desk.h"
#include "workbench/can/drive/objects.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kPage = SLIPSTACK_SOURCE_DIR "/docs/hardware.md";

std::vector<std::string> lines_of_page() {
  std::ifstream file(kPage);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// What depends on the place of the simulated axis, or on noise: only the name is compared.
std::string comparable(const std::string& line) {
  static const std::regex varying("^(606[34]h|6077h|60F4h|2501h:05)([^=]*=).*");
  return std::regex_replace(line, varying, "$1$2");
}

// A machine with its encoder the wrong way round, as `slipstack node --reversed encoder`.
class Session {
 public:
  Session() : desk_(1) {
    desk_.wiring = {.encoder_reversed = true, .checked = false};
    desk_.flash = host::HostNonvolatile{2, 2048, 8};
    desk_.power_on();
  }

  std::vector<std::string> answers(const std::string& command) {
    std::istringstream words(command);
    std::string word;
    words >> word;
    if (word == "sleep") {
      double seconds = 0.0;
      words >> seconds;
      for (int tick = 0; tick < static_cast<int>(1e4 * seconds); ++tick) desk_.drive->step();
      return {};
    }
    words >> word;
    EXPECT_EQ(word, "object") << command;
    std::string said;
    try {
      while (words >> word) {
        said += access_object(*desk_.client, word);
        for (int tick = 0; tick < 30; ++tick) desk_.drive->step();  // as long as a command takes
      }
    } catch (const UsageError& error) {
      said += std::string("slipstack: ") + error.what() + "\n";
    }
    std::vector<std::string> lines;
    std::istringstream text(said);
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

 private:
  Desk desk_;
};

TEST(Commissioning, IsAsThePageSays) {
  Session session;
  std::vector<std::string> written;
  std::vector<std::string> due;  // answers of the last command
  bool section = false;
  bool block = false;
  int commands = 0;
  for (const std::string& line : lines_of_page()) {
    if (line.rfind("## ", 0) == 0) section = line == "## Commissioning";
    const bool fence = line.rfind("```", 0) == 0;
    const bool command = section && block && line.rfind("$ ", 0) == 0;
    if (section && (fence || command)) {
      EXPECT_TRUE(due.empty()) << "not on the page: " << due.front();
      due.clear();
    }
    if (section && fence) block = !block;
    if (!section || !block || fence || command) {
      written.push_back(line);
    } else if (due.empty()) {
      ADD_FAILURE() << "not said: " << line;
    } else {
      EXPECT_EQ(comparable(line), comparable(due.front()));
      due.erase(due.begin());
    }
    if (!command) continue;
    ++commands;
    due = session.answers(line.substr(2));
    written.insert(written.end(), due.begin(), due.end());
  }
  EXPECT_GT(commands, 15);
  if (std::getenv("SLIPSTACK_WRITE_COMMISSIONING") == nullptr) return;
  std::ofstream file(kPage);
  for (const std::string& line : written) file << line << '\n';
}

}  // namespace
}  // namespace slipstack::workbench
