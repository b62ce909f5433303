// SPDX-License-Identifier: Apache-2.0
// synthetic_report KIND SEED OUT.json: the data of a report as JSON (NaN and stray bytes already replaced).
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>

#include "tests/browser/synthetic_report.h"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: synthetic_report KIND SEED OUT.json\n";
    return 2;
  }
  try {
    const auto data =
        slipstack::test::synthetic_report(argv[1], static_cast<std::uint32_t>(std::atoi(argv[2])));
    std::ofstream out(argv[3]);
    out << data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    out.close();
    if (!out) throw std::runtime_error(std::string("cannot write ") + argv[3]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
  return 0;
}
