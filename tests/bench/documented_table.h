// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

// A bench whose table stands on a page of docs/: one option of its program prints it, one test holds the page
// against it.
namespace slipstack {

/// What appends to `text` by the formats of printf; a piece has at most 199 characters.
inline auto printer_to(std::string& text) {
  return [&text](auto... values) {
    char piece[200];
    std::snprintf(piece, sizeof piece, values...);
    text += piece;
  };
}

/// The file has this table in it; where not, the message is the table of today.
inline void expect_page_has(const char* page, const std::string& table) {
  std::ifstream file(page);
  std::stringstream content;
  content << file.rdbuf();
  EXPECT_NE(content.str().find(table), std::string::npos) << table;
}

/// The main() of such a bench: with --table it prints table(), otherwise it runs the tests.
inline int print_table_or_run_tests(int count, char** words, std::string (*table)()) {
  ::testing::InitGoogleTest(&count, words);
  if (count > 1 && std::string(words[1]) == "--table") {
    std::cout << table();
    return 0;
  }
  return RUN_ALL_TESTS();
}

}  // namespace slipstack
