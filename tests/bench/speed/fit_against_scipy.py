#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the speed of `slipstack fit` with SciPy's bounded least squares on the same log and the same model, in one run.

The model: mass, 28 Maxwell elements of fixed slip distances (stiffnesses >= 0), and the Stribeck weakening with
its velocity and exponent to be found. Both clocks of the comparison cover the fit alone: scipy.optimize.least_squares
there, fit_effects and fit_robustly here (fit_bench.cpp). For SciPy, the states of the elements are computed
once, before its clock starts, while ours searches the slip distances, cross-validates and looks for outliers too. A
further line is the whole program: reading, filtering, noise, fit, standard errors, reduction, model file.

    tests/bench/speed/fit_against_scipy.py --samples 50000
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import tempfile
import time

import numpy
import scipy.optimize
import scipy.signal

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RATE_HZ = 2500
ELEMENTS = 28


def stop_operators(position_m, slip_m):
    """Deflections of elastic elements that slip at +-slip_m, samples x elements."""
    states = numpy.empty((len(position_m), len(slip_m)))
    state = numpy.zeros(len(slip_m))
    previous = position_m[0]
    for i, x in enumerate(position_m):
        state = numpy.clip(state + (x - previous), -slip_m, slip_m)
        states[i] = state
        previous = x
    return states


def low_passed(signals, cutoff_Hz):
    b, a = scipy.signal.butter(4, cutoff_Hz / (0.5 * RATE_HZ))
    return scipy.signal.filtfilt(b, a, signals, axis=0)


def fit_scipy(log, cutoff_Hz):
    """Relative error, seconds and processor seconds of SciPy's fit."""
    _, position, force = numpy.loadtxt(log, delimiter=",", comments="#", skiprows=6).T
    smooth = low_passed(position, 3.0 * cutoff_Hz)
    velocity = numpy.gradient(smooth, 1.0 / RATE_HZ)
    acceleration = numpy.gradient(velocity, 1.0 / RATE_HZ)
    slip = numpy.geomspace(0.5e-6, 2e-3, ELEMENTS)
    states = stop_operators(position, slip)
    target = low_passed(force, cutoff_Hz)

    def model(parameters):
        mass, stiffness, gain, tail, speed, exponent = (parameters[0], parameters[1:1 + ELEMENTS], *parameters[1 + ELEMENTS:])
        dry = states @ (1e5 * stiffness)
        u = (numpy.abs(velocity) / speed) ** exponent
        weakening = 1.0 + gain * numpy.exp(-u) + tail / (1.0 + u)
        return low_passed(mass * acceleration + dry * weakening, cutoff_Hz)

    start = numpy.concatenate([[30.0], numpy.full(ELEMENTS, 0.1), [0.1, 0.1, 0.02, 1.0]])
    lower = numpy.concatenate([[0.0], numpy.zeros(ELEMENTS), [0.0, 0.0, 1e-3, 0.5]])
    upper = numpy.concatenate([[1e3], numpy.full(ELEMENTS, 1e3), [5.0, 5.0, 1.0, 2.0]])
    begin, begin_processor = time.monotonic(), time.process_time()
    found = scipy.optimize.least_squares(lambda p: model(p) - target, start, bounds=(lower, upper), x_scale="jac", max_nfev=100)
    seconds, processor_s = time.monotonic() - begin, time.process_time() - begin_processor
    return numpy.linalg.norm(found.fun) / numpy.linalg.norm(target), seconds, processor_s


def processor_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=50000)
    parser.add_argument("--programs", default=str(REPOSITORY / "build/host/bin"))
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "log.csv")
        subprocess.run([f"{wanted.programs}/slipstack-sim", "log", "--setup", "pick_and_place", "--seed", "4", "--effects",
                        "stribeck", "--rate", str(RATE_HZ), "--seconds", str(wanted.samples / RATE_HZ), "--out", log,
                        "--truth", f"{log}.json"], check=True, capture_output=True)
        effects = ["inertia", "presliding_hysteresis", "stribeck"]
        alone = json.loads(subprocess.run([f"{wanted.programs}/fit_bench", log, *effects], check=True, capture_output=True).stdout)
        begin, begin_processor = time.monotonic(), processor_of_children()
        done = subprocess.run([f"{wanted.programs}/slipstack", "fit", log, "--effects", ",".join(effects),
                               "--model", f"{folder}/m.toml", "--json", "-"], check=True, capture_output=True)
        ours_s, ours_processor_s = time.monotonic() - begin, processor_of_children() - begin_processor
        ours = json.loads(done.stdout)["relative_error"]
        theirs, theirs_s, theirs_processor_s = fit_scipy(log, 0.02 * RATE_HZ)
    rows = [("slipstack, the fit alone", alone["seconds"], alone["processor_s"], alone["relative_error"]),
            ("slipstack fit, all of it", ours_s, ours_processor_s, ours),
            ("SciPy least_squares alone", theirs_s, theirs_processor_s, theirs)]
    print(f"{'':<28} {'seconds':>8} {'processor s':>12} {'of the force':>13} {'SciPy takes':>12}")
    for name, seconds, processor_s, error in rows:
        print(f"{name:<28} {seconds:8.2f} {processor_s:12.2f} {100.0 * error:11.3f} % {theirs_processor_s / processor_s:8.0f} x")


if __name__ == "__main__":
    main()
