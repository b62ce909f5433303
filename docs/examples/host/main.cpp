// SPDX-License-Identifier: Apache-2.0
// The friction force along a motion, in mN: what docs/examples/cortex_m prints too, line by line.
#include <cstdio>

#include "axis.h"

int main() {
  static slipstack::FrictionModel<float> model;
  model.prepare(example::parameters(), example::kScales);
  model.reset({});
  example::Motion motion;
  for (int tick = 0; tick < 200; ++tick) {
    const float force_N = model.step(motion.next()).total_N;
    std::printf("%d\n", static_cast<int>(force_N * 1000.0F));
  }
  return 0;
}
