#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Soaks the control tick in the emulator: random moves, parameters, faults; ticks from the SysTick exception.

  check_soak.py --image soak.elf [--ticks N]

SLIPSTACK_SOAK_TICKS sets the number of ticks too: 10000000 take some minutes.
"""

import argparse
import os
import sys

import emulator


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--ticks", type=int, default=int(os.environ.get("SLIPSTACK_SOAK_TICKS", "200000")))
    options = parser.parse_args()
    emulator.require(options.image)
    emulator.TIMEOUT_S = 300 + options.ticks // 2000
    lines = emulator.run(options.image, (str(options.ticks),))
    words = next(line for line in lines if line.startswith("soak ")).split()[1:]
    count = dict(zip(words[0::2], map(int, words[1::2])))
    print(", ".join(f"{name} {value}" for name, value in count.items()))
    faults = []
    if count["ticks"] < options.ticks:
        faults.append("it ended early")
    # Each injected loss is seen and counted; a jump is seen going and coming back unless a loss hides it.
    if not count["counted_losses"] <= count["losses"] or count["counted_losses"] < 0.7 * count["losses"]:
        faults.append("encoder losses do not fit")
    if not 0.7 * count["jumps"] <= count["counted_jumps"] <= 2 * count["jumps"]:
        faults.append("encoder jumps do not fit")
    if not 0.7 * count["over_currents"] <= count["counted_over_currents"] <= count["over_currents"]:
        faults.append("over-currents do not fit")
    # Overruns are a fault only while the current flows.
    if count["overruns"] != count["late"] or count["counted_overruns"] > count["late"]:
        faults.append("overruns do not fit")
    # A refusal stops a driven axis, and only that; two before one tick count once.
    if not 0.7 * count["refused_driving"] <= count["counted_parameters"] <= count["refused_driving"]:
        faults.append("refused parameters do not fit")
    if options.ticks >= 200000 and count["refused_driving"] in (0, count["refused"]):
        faults.append("no parameters were refused, or none at rest")
    if options.ticks >= 200000 and min(count["losses"], count["jumps"], count["late"], count["counted_overruns"]) == 0:
        faults.append("nothing was injected")
    for fault in faults:
        print(f"FAIL: {fault}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
