// SPDX-License-Identifier: Apache-2.0
// report_from_json IN.json OUT.html: renders report data that is already there, for tests and for work on the
// page.
#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "workbench/report/html/report_page.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: report_from_json IN.json OUT.html\n";
    return 2;
  }
  try {
    std::ifstream in(argv[1]);
    slipstack::workbench::write_report(argv[2], nlohmann::json::parse(in));
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
  return 0;
}
