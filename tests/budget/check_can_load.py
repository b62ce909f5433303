#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The whole firmware in the emulator under a full CAN bus: does a tick notice?

  check_can_load.py --image can_load.elf [--frames N]

SLIPSTACK_LOAD_FRAMES sets the number of frames too: 1000000 take some minutes.
"""

import argparse
import os
import sys

import emulator

BUS = {"quiet": "nothing", "foreign": "frames of others", "served": "and a master at work", "hostile": "broken, hostile"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--frames", type=int, default=int(os.environ.get("SLIPSTACK_LOAD_FRAMES", "40000")))
    options = parser.parse_args()
    emulator.require(options.image)
    emulator.TIMEOUT_S = 300 + options.frames // 1000
    runs = {}
    for traffic in BUS:
        lines = emulator.run(options.image, (traffic, str(options.frames)))
        words = next(line for line in lines if line.startswith("load ")).split()[1:]
        runs[traffic] = dict(zip(words[0::2], map(int, words[1::2])))
    print("instructions of a tick       ticks   frames    least     mean     most   entry   lost  malformed  aborts    sent")
    for traffic, run in runs.items():
        print(f"{BUS[traffic]:22}  {run['ticks']:10}{run['frames']:9}{run['least']:9}{run['mean_e3'] / 1000:9.2f}"
              f"{run['most']:9}{run['latest_entry']:8}{run['lost']:7}{run['malformed']:11}{run['aborts']:8}{run['sent']:8}")

    faults = []
    quiet = runs["quiet"]
    for traffic, run in runs.items():
        # Not only the same in sum: the checksum is over the count of each tick, in order.
        for what in ("ticks", "least", "most", "mean_e3", "checksum", "latest_entry"):
            if run[what] != quiet[what]:
                faults.append(f"{traffic}: {what} is {run[what]}, on a quiet bus {quiet[what]}")
        if not (run["flash_same"] and run["model_same"]) or run["faults"]:
            faults.append(f"{traffic}: flash, model or fault state are not what they were")
        if run["lost"]:
            faults.append(f"{traffic}: {run['lost']} frames lost")
        # The questions at the end are frames too.
        if traffic != "quiet" and not 0 <= run["received"] - run["frames"] <= 2:
            faults.append(f"{traffic}: {run['frames']} frames came, the node counts {run['received']}")
        if traffic != "quiet" and abs(run["frames"] - options.frames) > 1:
            faults.append(f"{traffic}: only {run['frames']} of {options.frames} frames came")
    if runs["served"]["sent"] < runs["served"]["frames"] // 2:
        faults.append("served: the node hardly answers")
    if runs["hostile"]["malformed"] == 0 or runs["hostile"]["aborts"] == 0:
        faults.append("hostile: nothing was refused")
    for fault in faults:
        print(f"FAIL: {fault}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
