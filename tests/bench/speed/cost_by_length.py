#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of a diagnosis by the length of the log: a table of time, processor time and memory, reading included.

On demand, since it takes minutes:  tests/bench/speed/cost_by_length.py --samples 31250,62500,125000,250000
The last lines fit cost = c x samples^p; p = 1 is linear; and report the growth of the peak memory from one length to
the next. Long logs of your own, which stay in their files:  --logs a.csv,b.csv
"""

import argparse
import json
import math
import pathlib
import subprocess
import tempfile

from measured import measured

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RATE_HZ = 2500


def simulate(program, log, samples):
    subprocess.run([program, "log", "--setup", "pick_and_place", "--seed", "9", "--effects", "viscous", "--rate",
                    str(RATE_HZ), "--seconds", str(samples / RATE_HZ), "--out", log, "--truth", f"{log}.json"],
                   check=True, capture_output=True)


def simulated(wanted, folder):
    """Logs of the lengths wanted, one after another under the same name."""
    for samples in map(int, wanted.samples.split(",")):
        log = f"{folder}/log.csv"
        simulate(f"{wanted.programs}/slipstack-sim", log, samples)
        yield log


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", default="31250,62500,125000,250000")
    parser.add_argument("--logs", help="CSV logs to diagnose in place of simulated ones")
    parser.add_argument("--programs", default=str(REPOSITORY / "build/host/bin"), help="folder of slipstack and slipstack-sim")
    wanted = parser.parse_args()
    points = []
    peaks = []
    print(f"{'samples':>9} {'seconds':>8} {'processor s':>12} {'us/sample':>10} {'peak MB':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for log in wanted.logs.split(",") if wanted.logs else simulated(wanted, folder):
            result = f"{folder}/result.json"
            seconds, processor, memory = measured([f"{wanted.programs}/slipstack", "diagnose", log, "--json", result])
            samples = json.loads(pathlib.Path(result).read_text(encoding="utf-8"))["samples"]
            points.append((math.log(samples), math.log(processor)))
            peaks.append((samples, memory))
            print(f"{samples:9d} {seconds:8.2f} {processor:12.2f} {1e6 * processor / samples:10.2f} {memory:8.0f}", flush=True)
    if len(points) > 1:
        mean = [sum(values) / len(points) for values in zip(*points)]
        slope = sum((x - mean[0]) * (y - mean[1]) for x, y in points) / sum((x - mean[0]) ** 2 for x, _ in points)
        print(f"processor time grows with samples to the power {slope:.2f}")
    for (few, before), (many, after) in zip(peaks, peaks[1:]):
        print(f"peak memory grows by {(after - before) * 2**20 / (many - few):.2f} bytes a sample from {few} to {many} samples")


if __name__ == "__main__":
    main()
