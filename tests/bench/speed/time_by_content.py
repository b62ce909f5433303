#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Wall time of a diagnosis over logs of different content: median, the time that 90 % of them keep, the longest.

On demand, on a machine without other work:  tests/bench/speed/time_by_content.py --first-seed 1 --logs 16
Each length is drawn anew: both set-ups in turn, with no hidden effect, one, two, or something outside the
catalogue. The goals are 1, 2 and 3 s (median) for 10^5, 5*10^5 and 10^6 samples, and 90 % of the logs within twice that.
"""

import argparse
import pathlib
import statistics
import subprocess
import tempfile

from measured import measured

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RATE_HZ = 2500
SETUPS = ("pick_and_place", "random")
CONTENTS = (["--effects", "none"], ["--effects", "random"], ["--effects", "random:2"],
            ["--effects", "none", "--outside", "line"], ["--effects", "none", "--outside", "bump"])


def drawn(seed, number):
    """How the log of this number is simulated."""
    contents = CONTENTS[number // len(SETUPS) % len(CONTENTS)]
    return ["--setup", SETUPS[number % len(SETUPS)], *contents, "--seed", str(seed + number)]


def ninth_decile(values):
    return sorted(values)[-(-9 * len(values) // 10) - 1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", default="100000,500000,1000000")
    parser.add_argument("--logs", type=int, default=2 * len(SETUPS) * len(CONTENTS), help="of each length")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--programs", default=str(REPOSITORY / "build/host/bin"), help="folder of slipstack and slipstack-sim")
    parser.add_argument("--each", action="store_true", help="a line for each log too")
    wanted = parser.parse_args()
    print(f"{'samples':>9} {'logs':>5} {'median s':>9} {'90 % s':>7} {'most s':>7} {'processor s':>12}")
    seed = wanted.first_seed
    with tempfile.TemporaryDirectory() as folder:
        for samples in map(int, wanted.samples.split(",")):
            log = f"{folder}/log.csv"
            walls, processors = [], []
            for number in range(wanted.logs):
                how = drawn(seed, number)
                subprocess.run([f"{wanted.programs}/slipstack-sim", "log", *how, "--rate", str(RATE_HZ),
                                "--seconds", str(samples / RATE_HZ), "--out", log], check=True, capture_output=True)
                wall, processor, _ = measured([f"{wanted.programs}/slipstack", "diagnose", log, "--stepwise"])
                walls.append(wall)
                processors.append(processor)
                if wanted.each:
                    print(f"{wall:9.2f} s  {' '.join(how)}", flush=True)
            seed += wanted.logs
            print(f"{samples:9d} {len(walls):5d} {statistics.median(walls):9.2f} {ninth_decile(walls):7.2f} {max(walls):7.2f} "
                  f"{statistics.median(processors):12.2f}", flush=True)


if __name__ == "__main__":
    main()
