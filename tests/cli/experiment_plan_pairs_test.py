#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The experiment planned from a first log separates what that log could not: several pairs of the catalogue, either
effect hidden, on an axis that shares no code with the diagnosis.

Each motion deliberately lacks some excitation. Pairs that no motion can separate are included: an effect that
contains another (a cable chain may pull with a constant force) can always explain it, and the simpler one is named.
"""

import json
import math
import unittest

import program

RATE_Hz = 1000
LIMITS = "stroke=0.02:0.38,velocity=0.4,acceleration=4,jerk=200,force=400"


class Motion:
    """Positions of an axis, sample by sample."""

    def __init__(self, start_m):
        self.positions_m = [start_m]

    def rest(self, seconds):
        self.positions_m += [self.positions_m[-1]] * int(seconds * RATE_Hz)
        return self

    def stroke(self, distance_m, speed_mps, ramp_s=0.1):
        """At constant speed, between ramps of the smooth step."""
        hold_s = abs(distance_m) / speed_mps - ramp_s
        sign = 1 if distance_m > 0 else -1
        for i in range(int((2 * ramp_s + hold_s) * RATE_Hz)):
            time_s = i / RATE_Hz
            u = min(1.0, time_s / ramp_s, (2 * ramp_s + hold_s - time_s) / ramp_s)
            self.positions_m.append(self.positions_m[-1] + sign * speed_mps * (3 * u * u - 2 * u ** 3) / RATE_Hz)
        return self

    def small_moves(self):
        """Pre-sliding: sines of some micrometres that fade in and out, so that the hysteresis is known."""
        for amplitude_m in (3e-6, 15e-6, 60e-6):
            start_m = self.positions_m[-1]
            for i in range(1, 3 * RATE_Hz + 1):
                time_s = i / RATE_Hz
                fade = min(1.0, time_s, 3.0 - time_s)
                self.positions_m.append(start_m + amplitude_m * math.sin(2.0 * math.pi * time_s) * fade)
        return self.rest(0.2)

    def write(self, path):
        path.write_text("time_s,position_m\n" + "\n".join(
            f"{i / RATE_Hz:.6f},{x:.12f}" for i, x in enumerate(self.positions_m)) + "\n")


def one_speed():
    motion = Motion(0.15).small_moves()
    for _ in range(4):
        motion.stroke(0.1, 0.15).rest(0.2).stroke(-0.1, 0.15).rest(0.2)
    return motion


def one_place():
    motion = Motion(0.15).small_moves()
    for speed_mps in (0.0005, 0.002, 0.004):
        motion.stroke(0.004, speed_mps, 0.05).rest(0.2).stroke(-0.004, speed_mps, 0.05).rest(0.2)
    return motion


def one_way(speed_mps=0.02):
    return Motion(0.04).small_moves().stroke(0.3, speed_mps).rest(0.5)


class Pairs(program.Workshop):
    def record(self, motion, effect, log):
        program.simulate(log, "--effects", effect, "--strength", "6", "--setpoints", str(motion),
                         seed=11)

    def diagnosed(self, *logs):
        return json.loads(self.assert_done("diagnose", *logs, "--json", "-").stdout)

    @staticmethod
    def confused(result):
        """Pairs that the log cannot tell apart."""
        return {frozenset((pair["effect"], pair["other"])) for pair in result["cannot_separate"]}

    def first_log(self, motion, hidden):
        motion().write(self.here / "poor.csv")
        self.record(self.here / "poor.csv", hidden, self.here / "first.csv")
        return self.diagnosed("first.csv")

    def after_the_plan(self, pair, hidden, logs):
        self.assert_done("experiment", "plan", "--log", "first.csv", "--for", ",".join(pair), "--seconds", "30", "--limits", LIMITS,
                         "--out", "plan.csv")
        self.record(self.here / "plan.csv", hidden, self.here / "second.csv")
        return self.diagnosed(*logs)

    def resolves(self, motion, hidden, other, logs=("second.csv",)):
        first = self.first_log(motion, hidden)
        pair = frozenset((hidden, other))
        self.assertIn(pair, self.confused(first), "the first log separates them: nothing to resolve")
        second = self.after_the_plan(sorted(pair), hidden, logs)
        self.assertEqual(second["candidates"][0]["effect"], hidden)
        self.assertEqual(second["verdict"], "missing_effect")
        self.assertNotIn(pair, self.confused(second))

    def test_drag_of_either_power_seen_at_one_speed(self):
        self.resolves(one_speed, "quadratic_drag", "viscous")

    @program.long
    def test_drag_and_a_rail_that_is_tighter_in_the_middle(self):
        self.resolves(one_speed, "quadratic_drag", "position_dependent_preload")

    @program.long
    def test_warming_and_a_cable_chain_on_one_way(self):
        self.resolves(lambda: one_way(0.01), "drift", "cable_chain_stiffness")

    @program.long
    def test_friction_that_falls_with_velocity_and_one_that_differs_by_direction_on_one_way(self):
        self.resolves(one_way, "stribeck", "direction_asymmetry")

    @program.long
    def test_a_cable_chain_seen_at_one_place(self):
        self.resolves(one_place, "cable_chain_stiffness", "offset_force")

    @program.long
    def test_a_constant_force_where_a_cable_chain_would_show(self):
        # The plan is for this pair: it has no small moves, which separate a constant force from friction that differs by
        # direction. The first log has them, so the two are diagnosed together.
        self.resolves(one_place, "offset_force", "cable_chain_stiffness", logs=("first.csv", "second.csv"))


if __name__ == "__main__":
    program.main()
