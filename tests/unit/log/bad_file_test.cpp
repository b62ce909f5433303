// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <string>

#include "tests/unit/log/log_support.h"

namespace slipstack::workbench::test {
namespace {

class BadFileTest : public testing::Test {
 protected:
  // Expects a refusal in one line, with `message` after the path, without delay.
  void expect_refused(const std::filesystem::path& path, const std::string& message) const {
    const auto start = std::chrono::steady_clock::now();
    const std::string refused = refusal_of_file(path);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(refused.substr(0, path.string().size() + message.size()), path.string() + message);
    EXPECT_EQ(broken_message(refused, path.string()), "") << refused;
    EXPECT_LT(elapsed.count(), 1.0) << "refusing must not wait or read it all";
  }

  static long peak_memory_KiB() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  }

  TemporaryDirectory directory_;
};

TEST_F(BadFileTest, Missing) {
  expect_refused(directory_ / "no.csv", ": cannot be opened: No such file");
}

TEST_F(BadFileTest, MissingFolder) {
  expect_refused(directory_ / "no/log.csv", ": cannot be opened: No such file");
}

TEST_F(BadFileTest, Directory) {
  expect_refused(directory_ / "", ": is a directory; ");
}

TEST_F(BadFileTest, ZeroBytes) {
  expect_refused(directory_.write("a.csv", ""), ": the file is empty; ");
}

TEST_F(BadFileTest, Pipe) {
  ASSERT_EQ(::mkfifo((directory_ / "pipe").c_str(), 0600), 0);
  expect_refused(directory_ / "pipe", ": is not a regular file; ");
}

TEST_F(BadFileTest, Devices) {
  expect_refused("/dev/zero", ": is not a regular file; ");
  expect_refused("/dev/null", ": is not a regular file; ");
}

TEST_F(BadFileTest, LinkThatGoesNowhere) {
  std::filesystem::create_symlink(directory_ / "no.csv", directory_ / "link.csv");
  expect_refused(directory_ / "link.csv", ": cannot be opened: No such file");
}

TEST_F(BadFileTest, LinkInACircle) {
  std::filesystem::create_symlink(directory_ / "link.csv", directory_ / "link.csv");
  expect_refused(directory_ / "link.csv", ": cannot be opened: Too many levels");
}

TEST_F(BadFileTest, NotPermitted) {
  if (::geteuid() == 0) GTEST_SKIP() << "SKIP: root may read everything";
  const auto path = directory_.write("a.csv", usual_log());
  ::chmod(path.c_str(), 0);
  expect_refused(path, ": cannot be opened: Permission denied");
}

// A sparse file of two gibibytes is neither read through nor held in memory.
TEST_F(BadFileTest, SparseFromTheBeginning) {
  const auto path = directory_.write("a.csv", "");
  std::filesystem::resize_file(path, std::uintmax_t{2} << 30);
  const long before = peak_memory_KiB();
  expect_refused(path, ":1: NUL bytes where text should be");
  EXPECT_LT(peak_memory_KiB() - before, 64 * 1024);
}

TEST_F(BadFileTest, SparseBehindUsableRows) {
  const auto path = directory_.write("a.csv", usual_log());
  std::filesystem::resize_file(path, std::uintmax_t{2} << 30);
  const long before = peak_memory_KiB();
  expect_refused(path, ":203: NUL bytes where text should be");
  EXPECT_LT(peak_memory_KiB() - before, 64 * 1024);
}

TEST_F(BadFileTest, TenMegabytesWithoutANewline) {
  expect_refused(directory_.write("a.csv", std::string(10'000'000, 'x')),
                 ":1: the line is longer than 65536 bytes; ");
}

TEST_F(BadFileTest, BinaryGarbage) {
  std::string bytes;
  for (unsigned i = 0; i < 100'000; ++i) bytes += static_cast<char>((i * 2654435761U) >> 24);
  const auto path = directory_.write("a.csv", bytes);
  EXPECT_EQ(broken_message(refusal_of_file(path), path.string()), "") << refusal_of_file(path);
}

TEST_F(BadFileTest, NameWithNewlineStaysOneLine) {
  const auto path = directory_.write("a\nb.csv", "");
  const std::string message = refusal_of_file(path);
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_NE(message.find("a b.csv: the file is empty"), std::string::npos);
}

TEST_F(BadFileTest, AFileIsReadWhateverItsName) {
  const Log log = read_log(directory_.write("log.mat", usual_log()));
  EXPECT_EQ(log.path, (directory_ / "log.mat").string());
  EXPECT_EQ(log.position_m, parse_text(usual_log()).position_m);
}

}  // namespace
}  // namespace slipstack::workbench::test
