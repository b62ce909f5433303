# SPDX-License-Identifier: Apache-2.0
"""A million steps of the friction core in one call of Python cost what the same loop costs in C++.

Counted are the instructions of the second of two repetitions (valgrind; the first has what happens once), which no other
work on the machine changes. Where there is no valgrind, user seconds of repetitions that alternate, the median of each.
"""

import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys

import numpy
import pytest

SCRIPT = pathlib.Path(__file__).with_name("friction_speed.py")
PROGRAMS = {"C++": [os.environ.get("FRICTION_SPEED", "")], "Python": [sys.executable, "-B", str(SCRIPT)]}
SAMPLES = 1_000_000
# Beside the step Python looks whether the position is finite: four instructions, 7 % of the cheaper step (60). The rest is
# room for compilers. A model that its loop must load anew in each step had 1.32 times the instructions (2026-11-25).
MOST = 1.2
LEAST = 0.9  # fewer than in C++: then the two do not compute the same
MOST_BY_SECONDS = 2.0  # medians beside other work differed by a fifth in either direction
ALTERNATIONS = 7


@pytest.fixture(scope="module")
def positions(tmp_path_factory):
    path = tmp_path_factory.mktemp("positions") / "positions.f64"
    draw = numpy.random.default_rng(20)
    numpy.cumsum(draw.normal(0.0, 1.0, SAMPLES) * draw.choice([0.01, 0.1, 1.0], SAMPLES)).tofile(path)
    return str(path)


def run(language, *arguments, before=()):
    return subprocess.run([*before, *PROGRAMS[language], *map(str, arguments)], capture_output=True, text=True, check=True, timeout=500,
                          env={**os.environ, "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1"})


def instructions(language, model, positions):
    """Of one repetition."""
    counts = []
    for repetitions in (1, 2):
        done = run(language, model, positions, repetitions, before=("valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"))
        counts.append(int(re.search(r"I +refs: +([\d,]+)", done.stderr)[1].replace(",", "")))
    return counts[1] - counts[0]


def user_s(model, positions):
    """Median of repetitions that alternate, by language."""
    taken = {language: [] for language in PROGRAMS}
    for _ in range(ALTERNATIONS):
        for language in PROGRAMS:
            seconds = [float(line.split()[0]) for line in run(language, model, positions, 3).stdout.splitlines()]
            taken[language].append(min(seconds))
    return {language: statistics.median(values) for language, values in taken.items()}


@pytest.mark.parametrize("model", ["MaxwellSlip", "MemoryStack"])
def test_steps_cost_what_they_cost_in_cpp(model, positions, capsys):
    forces = {language: run(language, model, positions, 1).stdout.split()[1] for language in PROGRAMS}
    assert forces["Python"] == forces["C++"]
    seconds = user_s(model, positions)
    text = f"{model}: {1e9 * seconds['Python'] / SAMPLES:.1f} ns a step, in C++ {1e9 * seconds['C++'] / SAMPLES:.1f} ns"
    cost, least, most = seconds, 1.0 / MOST_BY_SECONDS, MOST_BY_SECONDS
    if shutil.which("valgrind"):
        cost = {language: instructions(language, model, positions) for language in PROGRAMS}
        least, most = LEAST, MOST
        text += f"; {cost['Python'] / SAMPLES:.1f} instructions, in C++ {cost['C++'] / SAMPLES:.1f}"
    with capsys.disabled():
        print(f"\n{text}")
    assert least < cost["Python"] / cost["C++"] < most, text
