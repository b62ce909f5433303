// SPDX-License-Identifier: Apache-2.0
// What the vectorised friction core of Python is compared with: the same models along the same positions, one
// step after the other (friction_speed_test.py).
//
//   friction_speed MODEL POSITIONS REPETITIONS: prints the user seconds of each repetition and the sum of the
//   forces
#include <fmt/format.h>
#include <sys/resource.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <vector>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"

namespace {

constexpr std::size_t kElements = 10;  // as on the controller (firmware/effects/presliding_hysteresis.h)
constexpr std::size_t kDepth = 16;     // firmware/control/force/hysteresis_memory.h

std::vector<double> positions_in(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> positions(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(positions.data()),
            static_cast<std::streamsize>(positions.size() * sizeof(double)));
  return positions;
}

double user_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

template <class Model>
void run(Model& model, const std::vector<double>& positions, int repetitions) {
  for (int i = 0; i < repetitions; ++i) {
    model.reset(0.0);
    std::vector<double> forces(positions.size());
    const double before_s = user_s();
    for (std::size_t k = 0; k < positions.size(); ++k) forces[k] = model.step(positions[k]);
    const double taken_s = user_s() - before_s;
    double sum = 0.0;
    for (const double force : forces) sum += force;
    fmt::print("{:.6f} {:.17g}\n", taken_s, sum);
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) return 2;
  const std::vector<double> positions = positions_in(words[2]);
  const int repetitions = std::atoi(words[3]);
  if (std::string_view(words[1]) == "MaxwellSlip") {
    std::array<double, kElements> slip_distance{};
    std::array<double, kElements> stiffness{};
    for (std::size_t i = 0; i < kElements; ++i) {
      slip_distance[i] = 0.5 * static_cast<double>(i + 1);
      stiffness[i] = 1.0 / static_cast<double>(i + 1);
    }
    slipstack::MaxwellSlip<kElements, double, double> model;
    static_cast<void>(model.set_elements(slip_distance, stiffness));
    run(model, positions, repetitions);
  } else {
    slipstack::MemoryStack<slipstack::RationalCurve<double>, kDepth> model(
        slipstack::RationalCurve<double>{8.0, 2.0});
    run(model, positions, repetitions);
  }
  return 0;
}
