#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The frequency responses of the pick-and-place axis by slipstack and by SciPy, in one run, at the same accuracy.

    tests/bench/experiments/frf_against_scipy.py [--slipstack PROGRAM] [--points N] [--method M] [--tolerance T]

5 forces x 40 frequencies, swept up, each held until it has settled by the same rule. SciPy integrates the same equation
as any SciPy user would who wants to be fast: solve_ivp from event to event (reversal, closing of a loop) on the smooth
virgin curve, the Fourier integrals as two more states, plain floats in the right-hand side, force levels on as many
processes as slipstack has threads. What each run misses is taken from a third, tight run of slipstack; that the two
programs mean the same is seen from SciPy's error being of the size of its tolerance.

Needs python3-scipy. Ends with the ratio of the times; status 1 when it is below 100.
"""

import argparse
import json
import math
import multiprocessing
import os
import pathlib
import subprocess
import sys
import time

import numpy
import scipy
from scipy.integrate import solve_ivp

ROOT = pathlib.Path(__file__).resolve().parents[3]
FORCES_N = [3.75, 6.75, 9.75, 12.75, 15.75]
LOW_HZ, HIGH_HZ = 1.0, 100.0
SETTLED = 1e-4
LEAST_PERIODS, MOST_PERIODS = 4, 400

# sim_host/setups/pick_and_place.toml
MASS_KG = 35.45
EXP_N, EXP_M = 6.5, 6.5e-6
RAT_N, RAT_M = 5.5, 7.5e-6
TRAVEL_M = 1e-5


def curve(u):
    """The virgin curve at u >= 0; a hair behind zero it goes on straight."""
    if u <= 0.0:
        return u * (EXP_N / EXP_M + 2.0 * RAT_N / RAT_M)
    r = u / RAT_M
    return -EXP_N * math.expm1(-u / EXP_M) + RAT_N * r * (2.0 + r) / ((1.0 + r) * (1.0 + r))


class Axis:
    """Mass on a memory of reversal points; moved from event to event."""

    def __init__(self, force_N, method, tolerance):
        self.force_N, self.method, self.tolerance = force_N, method, tolerance
        self.x = self.v = 0.0
        self.direction, self.reversals = 1, []
        self.swing_m, self.speed = 1e-3 * TRAVEL_M, 1e-3 * TRAVEL_M * 2 * math.pi * LOW_HZ
        self.last_turn_m = 0.0
        self.evaluations = 0
        self.step_s = 1e-4

    def branch(self):
        """Start, force there, scale, and where the innermost loop closes."""
        if not self.reversals:
            return 0.0, 0.0, 1.0, self.direction * math.inf
        x, force = self.reversals[-1]
        return x, force, 2.0, self.reversals[-2][0] if len(self.reversals) > 1 else -x

    def friction(self, x):
        start, force, scale, _ = self.branch()
        return force + self.direction * scale * curve(self.direction * (x - start) / scale)

    def close(self):
        del self.reversals[-2:]

    def turn(self):
        while abs(self.x - self.branch()[3]) <= 1e-12 * TRAVEL_M:
            self.close()
        if self.reversals or abs(self.x) > 1e-12 * TRAVEL_M:
            self.reversals.append((self.x, self.friction(self.x)))
        self.direction = -self.direction
        while self.reversals and abs(self.x - self.branch()[3]) <= 1e-12 * TRAVEL_M:
            self.close()
        self.swing_m = max(abs(self.x - self.last_turn_m), 0.5 * self.swing_m)
        self.last_turn_m = self.x

    def period(self, w, start_s, period_s):
        """One period from a time at which the force's angle is a whole number of turns; its fundamental."""
        origin, integral_c, integral_s, t = self.x, 0.0, 0.0, 0.0
        while t < period_s:
            push = self.force_N * math.cos(w * t) - self.friction(self.x)
            if self.v == 0.0 and push * self.direction < 0.0:
                self.turn()
            x0, f0, scale, closing = self.branch()
            d, amplitude = self.direction, self.force_N

            def rates(time_s, y):
                cosine = math.cos(w * time_s)
                x = y[0]
                friction = f0 + d * scale * curve(d * (x - x0) / scale)
                return (y[1], (amplitude * cosine - friction) / MASS_KG, (x - origin) * cosine,
                        (x - origin) * math.sin(w * time_s))

            def reversal(_, y):
                return y[1]
            reversal.terminal, reversal.direction = True, -d
            events = [reversal]
            if math.isfinite(closing):
                def closure(_, y):
                    return y[0] - closing
                closure.terminal, closure.direction = True, d
                events.append(closure)
            small = self.tolerance
            scales = (self.swing_m, max(self.speed, 1e-12), self.swing_m * period_s, self.swing_m * period_s)
            done = solve_ivp(rates, (t, period_s), (self.x, self.v, integral_c, integral_s), method=self.method,
                             events=events, rtol=small, atol=[small * s for s in scales],
                             first_step=min(self.step_s, 0.5 * (period_s - t)))
            self.evaluations += done.nfev
            if len(done.t) > 2:
                self.step_s = max(done.t[1:] - done.t[:-1])
                self.step_s = max(0.2 * self.step_s, 1e-9)
            self.speed = max(0.7 * self.speed, float(numpy.max(numpy.abs(done.y[1]))))
            t = float(done.t[-1])
            self.x, self.v, integral_c, integral_s = (float(value) for value in done.y[:, -1])
            if done.status == 1:
                if len(done.t_events[0]):
                    self.v = 0.0
                    self.turn()
                else:
                    self.x = closing
                    self.close()
        return 2.0 / period_s * complex(integral_c, -integral_s)


def settled_response(axis, frequency_Hz):
    w, period_s = 2.0 * math.pi * frequency_Hz, 1.0 / frequency_Hz
    last, last_change, calm = 0j, 0.0, 0
    for count in range(1, MOST_PERIODS + 1):
        now = axis.period(w, 0.0, period_s)
        change, small = abs(now - last), False
        if count >= 3:
            q = min(change / max(last_change, 1e-300), 0.98)
            small = change * max(q / (1.0 - q), 0.1) <= SETTLED * abs(now)
        last, last_change, calm = now, change, calm + 1 if small else 0
        if calm >= 2 and count >= LEAST_PERIODS:
            break
    return last, count


def scipy_level(job):
    force_N, frequencies, method, tolerance = job
    axis = Axis(force_N, method, tolerance)
    found, periods = [], 0
    for frequency_Hz in frequencies:
        response, count = settled_response(axis, frequency_Hz)
        found.append(response)
        periods += count
    return found, periods, axis.evaluations


def slipstack_run(program, points, tolerance, settled, threads, most=MOST_PERIODS):
    command = [program, "experiment", "stepped-sine", "--setup", "pick_and_place", "--direction", "up", "--points",
               str(points), "--tolerance", str(tolerance), "--settled", str(settled), "--threads", str(threads),
               "--most-periods", str(most), "--json", "-"]
    start = time.perf_counter()
    done = subprocess.run(command, check=True, capture_output=True)
    seconds = time.perf_counter() - start
    rows = json.loads(done.stdout)["points"]
    found = [row["amplitude_m"] * complex(math.cos(row["phase_rad"]), math.sin(row["phase_rad"])) for row in rows]
    return numpy.array(found), seconds, sum(row["periods"] for row in rows)


def errors(found, reference):
    relative = numpy.abs(found - reference) / numpy.abs(reference)
    return numpy.median(relative), numpy.percentile(relative, 95), numpy.max(relative)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slipstack", default=str(ROOT / "build/host/bin/slipstack"))
    parser.add_argument("--points", type=int, default=40)
    parser.add_argument("--method", default="RK45", choices=["RK45", "DOP853", "RK23", "LSODA"],
                        help="RK45 is what SciPy takes by default, DOP853 its fastest here")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="of both")
    wanted = parser.parse_args()
    processors = min(2, os.cpu_count() or 1)
    frequencies = [LOW_HZ * (HIGH_HZ / LOW_HZ) ** (i / (wanted.points - 1)) for i in range(wanted.points)]
    frequencies[-1] = HIGH_HZ

    reference, _, _ = slipstack_run(wanted.slipstack, wanted.points, 1e-11, 1e-7, processors, 4000)
    slipstack_run(wanted.slipstack, wanted.points, wanted.tolerance, SETTLED, processors)  # warm
    runs = [slipstack_run(wanted.slipstack, wanted.points, wanted.tolerance, SETTLED, processors) for _ in range(3)]
    ours, seconds, periods = min(runs, key=lambda run: run[1])

    start = time.perf_counter()
    jobs = [(force_N, frequencies, wanted.method, wanted.tolerance) for force_N in FORCES_N]
    with multiprocessing.Pool(processors) as pool:
        levels = pool.map(scipy_level, jobs, chunksize=1)
    scipy_seconds = time.perf_counter() - start
    theirs = numpy.array([response for found, _, _ in levels for response in found])
    scipy_periods = sum(count for _, count, _ in levels)

    print(f"{len(FORCES_N)} forces x {wanted.points} frequencies, up, settled to {SETTLED:g}; {processors} processors each")
    print(f"{'':24}{'time s':>10}{'periods':>10}{'error median':>14}{'95 %':>10}{'largest':>10}")
    for name, found, took, count in (("slipstack", ours, seconds, periods),
                                     (f"SciPy {scipy.__version__} {wanted.method}", theirs, scipy_seconds, scipy_periods)):
        median, most, worst = errors(found, reference)
        print(f"{name:24}{took:10.3f}{count:10.0f}{median:14.1e}{most:10.1e}{worst:10.1e}")
    ratio = scipy_seconds / seconds
    print(f"slipstack is {ratio:.0f} times faster")
    return 0 if ratio >= 100.0 else 1


if __name__ == "__main__":
    sys.exit(main())
