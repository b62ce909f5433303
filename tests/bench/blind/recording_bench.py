#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How often `diagnose` tells what the recording did to the force: a mode that rings above a twentieth of the sampling
rate (as what is left, or by the name of the effect), and a force that was low-passed alone. Random axes of slipstack-sim,
every third under control, each recorded with either and without; what is told is compared with the truth.

By hand, on the seeds that docs/theory.md states:  tests/bench/blind/recording_bench.py --first-seed S --count 24
ctest runs a few short ones.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SLIPSTACK = os.environ.get("SLIPSTACK", str(REPOSITORY / "build/host/bin/slipstack"))
SLIPSTACK_SIM = os.environ.get("SLIPSTACK_SIM", str(REPOSITORY / "build/host/bin/slipstack-sim"))
KINDS = ("ring", "force_filter")
# A named mode has the interval of its fit, which does not contain what the form of the friction makes of it.
FORM_OF_MODE = 0.01
# What is told of the cut and the true one differ by this share at most, as in estimate_test (FilteredForce).
TOLERANCE_OF_CUT = 0.15
HERTZ = {"mHz": 1e-3, "Hz": 1.0, "kHz": 1e3}


def simulate(seed, kind, wanted, folder):
    """The log with this and nothing else outside the catalogue, and its truth; none where the loop loses the axis."""
    log, truth = folder / "log.csv", folder / "truth.json"
    command = [SLIPSTACK_SIM, "log", "--setup", "random", "--seed", str(seed), "--out", str(log), "--truth", str(truth)]
    command += ["--effects", "none"] if kind is None else ["--outside", kind]
    command += ["--closed-loop"] if seed % 3 == 0 else []
    command += ["--seconds", str(wanted.seconds)] if wanted.seconds else []
    command += ["--rate", str(wanted.rate)] if wanted.rate else []
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        assert "lost the axis" in done.stderr, done.stderr
        return None, None
    return log, json.loads(truth.read_text())


def hertz(number, unit):
    return float(number) * HERTZ[unit]


def diagnosed(log, folder):
    """Verdict, what is named, and what is told of a ring (frequency and half width) and of a filter (cut), in Hz."""
    result = folder / "result.json"
    done = subprocess.run([SLIPSTACK, "diagnose", str(log), "--json", str(result)], capture_output=True, text=True, check=True)
    found = json.loads(result.read_text())
    left = (found["unexplained"] or {}).get("description", "")
    first = found["candidates"][0] if found["verdict"] == "missing_effect" else None
    is_mode = bool(first) and first["effect"] == "structural_resonance"
    if is_mode:
        left = first["evidence"]
    ring = re.search(r"(?:what is left|residual) rings at ([\d.]+)(?: \+- ([\d.]+))? (m?k?Hz)", left)
    cut = re.search(r"low-passed alone, to half of its amplitude at ([\d.]+) (m?k?Hz)", " ".join(done.stdout.split()))
    where = found["unexplained"]["coordinate"] if found["unexplained"] else ""
    named = first["effect"] if first else where
    ring = ring and (hertz(ring[1], ring[3]), hertz(ring[2] or 0.0, ring[3]))
    if ring and is_mode:
        ring = (ring[0], max(ring[1], FORM_OF_MODE * ring[0]))
    return {"ring": ring,
            "force_filter": cut and hertz(cut[1], cut[2]),
            "said": f"{found['verdict']} {named}".strip()}


def is_right(kind, told, truth):
    """Whether the frequency is that of the truth: a ring within what is told, a cut within its tolerance."""
    if kind == "ring":
        return abs(told[0] - truth["frequency_Hz"]) <= told[1]
    return abs(told / truth["half_amplitude_Hz"] - 1.0) <= TOLERANCE_OF_CUT


def hidden_text(kind, truth):
    if kind is None:
        return ""
    if kind == "ring":
        return f"{truth['frequency_Hz']:.1f} Hz, {100 * truth['damping_ratio']:.2f} %, {truth['rms_over_noise']:.1f} x noise"
    return f"{truth['half_amplitude_Hz']:.1f} Hz, order {truth['order']}, {'both ways' if truth['zero_phase'] else 'one way'}"


def told_text(told):
    parts = []
    if told["ring"]:
        parts.append("rings at {:.1f} +- {:.1f} Hz".format(*told["ring"]))
    if told["force_filter"]:
        parts.append(f"cut at {told['force_filter']:.1f} Hz")
    return ", ".join(parts) or "-"


class Tally:
    """Logs with each kind: how many, told, told rightly, told on logs without it. And those without both."""

    def __init__(self):
        self.logs = {kind: 0 for kind in (None, *KINDS)}
        self.told = {kind: 0 for kind in KINDS}
        self.right = {kind: 0 for kind in KINDS}
        self.false = {kind: 0 for kind in KINDS}

    def add(self, kind, told, right):
        self.logs[kind] += 1
        for one in KINDS:
            if told[one] and one == kind:
                self.told[one] += 1
                self.right[one] += right
            elif told[one]:
                self.false[one] += 1

    def without(self, kind):
        return sum(self.logs.values()) - self.logs[kind]

    def text(self):
        names = {"ring": "rings above the band", "force_filter": "force low-passed alone"}
        return "\n".join(f"{names[kind]:23} {self.told[kind]:3d} of {self.logs[kind]} told, {self.right[kind]} with the right "
                         f"frequency; without it {self.false[kind]} of {self.without(kind)}" for kind in KINDS if self.logs[kind])


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--first-seed", type=int, default=1)
    options.add_argument("--count", type=int, default=24, help="axes; each is recorded with every kind and without")
    options.add_argument("--kind", default=",".join(KINDS), help="ring, force_filter or both")
    options.add_argument("--seconds", type=float, default=0.0, help="of each log; drawn with the axis without it")
    options.add_argument("--rate", type=float, default=0.0, help="samples per second; drawn with the axis without it")
    options.add_argument("--least", type=int, default=None, help="status 1 where fewer of a kind are told with the right "
                         "frequency, or one on a log without it")
    wanted = options.parse_args()
    kinds = wanted.kind.split(",")
    if not set(kinds) <= set(KINDS):
        options.error(f"--kind: {wanted.kind} is none of {', '.join(KINDS)}")
    tally = Tally()
    with tempfile.TemporaryDirectory(prefix="slipstack-recording-") as scratch:
        folder = pathlib.Path(scratch)
        for seed in range(wanted.first_seed, wanted.first_seed + wanted.count):
            for kind in (None, *kinds):
                log, truth = simulate(seed, kind, wanted, folder)
                if log is None:
                    print(f"{seed:10d} {kind or '-':13} the controller lost the axis: not counted", flush=True)
                    continue
                told = diagnosed(log, folder)
                hidden = truth["outside_parameters"].get(kind, {})
                right = bool(kind and told[kind]) and is_right(kind, told[kind], hidden)
                tally.add(kind, told, right)
                print(f"{seed:10d} {kind or '-':13}{'closed ' if seed % 3 == 0 else '':8}{hidden_text(kind, hidden):38}"
                      f"{told_text(told):36}{told['said']}", flush=True)
    print(tally.text())
    if wanted.least is None:
        return 0
    return int(any(tally.right[kind] < wanted.least or tally.false[kind] for kind in kinds))


if __name__ == "__main__":
    sys.exit(main())
