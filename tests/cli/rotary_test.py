#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A rotary axis: the same physics as a linear one, with units of its own in every output.

A linear log becomes that of a rotary axis by a radius r: angle = position / r, torque = force r, inertia = mass r^2.
Whatever is found must scale in the same way.
"""

import json
import os
import pathlib
import re
import unittest

import program

SHARED = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY.parent / "shared"))
# At the reference radius (workbench/base/axis_units.h) all bounds of the search scale with the log; at another the search
# begins elsewhere and ends at the same optimum.
REFERENCE_RADIUS_M = 0.05

# A number with a unit of a linear axis: N, m, kg, ... not followed by the rest of a rotary unit.
LINEAR_UNIT = re.compile(r"\d[\s\u00a0](?:[mukµ]?N(?![\s·]m)(?:\b(?!/√)|/m)|[munkµ]?m(?:/s[2²]?)?\b(?!/√)|kg(?!·)(?![\s]m2))(?![\w/])")


def rotary(lines, radius_m, angle="rad", per_rad=1.0):
    """The lines of a linear log as those of a rotary axis."""
    out = []
    for line in lines:
        if line.startswith("# mass_kg:"):
            out.append(f"# inertia_kg_m2: {float(line.split(':')[1]) * radius_m**2!r}")
        elif line.startswith("# encoder_resolution_m:"):
            out.append(f"# encoder_resolution_rad: {float(line.split(':')[1]) / radius_m!r}")
        elif line.startswith("#"):
            pass
        elif line.startswith("time_s"):
            assert line == "time_s,position_m,force_N"
            out.append(f"time_s,position_{angle},torque_Nm")
        else:
            time_s, position_m, force_N = map(float, line.split(","))
            out.append(f"{time_s!r},{position_m / radius_m * per_rad!r},{force_N * radius_m!r}")
    return "\n".join(out) + "\n"


def keys_of(value):
    if isinstance(value, dict):
        for key, item in value.items():
            yield key
            yield from keys_of(item)
    elif isinstance(value, list):
        for item in value:
            yield from keys_of(item)


class Rotary(program.Workshop):
    def setUp(self):
        super().setUp()
        self.lines = (self.here / "good.csv").read_text().splitlines()

    def write(self, name, *arguments):
        (self.here / name).write_text(rotary(self.lines, *arguments), encoding="utf-8")

    def done(self, *arguments):
        done = program.run(*arguments, cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.decode()

    def refused(self, *arguments):
        done = program.run(*arguments, cwd=self.here)
        self.assertEqual(done.returncode, 2, done.stderr)
        lines = done.stderr.decode().splitlines()
        self.assertEqual(len(lines), 1, lines)
        return lines[0]

    def assert_rotary_units(self, text, what):
        """No number has a unit of a linear axis."""
        self.assertIsNone(LINEAR_UNIT.search(text), (what, LINEAR_UNIT.findall(text)[:3], text[:3000]))

    def assert_rotary_json(self, path):
        result = program.published((self.here / path).read_text())
        self.assertEqual(result["axis"], "rotary")
        for key in keys_of(result):
            self.assertFalse(re.search(r"_(N|m|kg|mps\d?)$", key), (path, key))
        return result

    def test_numbers_scale_with_the_radius(self):
        fit = ("fit", "--effects", "inertia,presliding_hysteresis,viscous")
        self.done("diagnose", "good.csv", "--json", "linear.json")
        self.done(fit[0], "good.csv", *fit[1:], "--model", "l.toml", "--json", "linear_fit.json")
        linear = json.loads((self.here / "linear.json").read_text())
        linear_fit = json.loads((self.here / "linear_fit.json").read_text())
        for radius_m, tolerance in ((REFERENCE_RADIUS_M, 1e-4), (1.0, 0.1), (0.2, 0.1)):
            with self.subTest(radius_m=radius_m):
                self.write("r.csv", radius_m)
                self.done("diagnose", "r.csv", "--json", "r.json")
                found = self.assert_rotary_json("r.json")
                self.assertEqual(found["verdict"], linear["verdict"])
                self.assertEqual(found["candidates"][0]["effect"], linear["candidates"][0]["effect"])
                self.assert_scaled(found["noise_floor_Nm"], linear["noise_floor_N"] * radius_m,
                                   max(tolerance, 0.04))  # its saturated model searches other periods: one turn too
                self.assert_scaled(found["baseline"]["holdout_rmse_Nm"], linear["baseline"]["holdout_rmse_N"] * radius_m, tolerance)
                self.assert_scaled(found["best"]["holdout_rmse_Nm"], linear["best"]["holdout_rmse_N"] * radius_m, tolerance)
                self.done(fit[0], "r.csv", *fit[1:], "--model", "r.toml", "--json", "r_fit.json")
                found = self.assert_rotary_json("r_fit.json")
                for mine, its in zip(found["parameters"], linear_fit["parameters"]):
                    if mine["effect"] == "viscous":  # N s/m: r^2
                        self.assert_scaled(mine["parameters"][0]["value"], its["parameters"][0]["value"] * radius_m**2, tolerance)
                        self.assertEqual(mine["parameters"][0]["unit"], "N m s/rad")
                    if mine["effect"] == "inertia":
                        self.assertEqual(mine["parameters"][0]["unit"], "kg m2")
                        self.assert_scaled(mine["parameters"][0]["value"], its["parameters"][0]["value"] * radius_m**2, 1e-12)

    def assert_scaled(self, found, expected, tolerance):
        self.assertLess(abs(found / expected - 1.0), tolerance, (found, expected))

    def test_the_unit_of_the_angle_changes_no_number(self):
        self.write("rad.csv", 0.1)
        results = []
        for unit, per_rad in (("rad", 1.0), ("deg", 57.29577951308232), ("rev", 0.15915494309189535)):
            self.write("r.csv", 0.1, unit, per_rad)
            text = self.done("diagnose", "r.csv", "--json", "r.json")
            self.assert_rotary_units(text, unit)
            results.append(self.assert_rotary_json("r.json")["best"]["holdout_rmse_Nm"])
        self.assert_scaled(results[1], results[0], 1e-6)
        self.assert_scaled(results[2], results[0], 1e-6)

    def test_no_word_of_a_linear_axis(self):
        self.write("r.csv", REFERENCE_RADIUS_M)
        text = self.done("diagnose", "r.csv", "--json", "r.json", "--report", "r.html")
        found = json.loads((self.here / "r.json").read_text())
        told = [text] + [one[key] for one in found["candidates"] for key in ("cause", "confirm_with", "evidence")]
        for one in told:
            self.assertNotRegex(one, r"(?i)\b(rail|slide|carriage|guideway|bellow)s?\b")
            self.assertNotIn(" | ", one)
        self.assertIn("of the torque", text)
        # In wrong units: what is declared is a moment of inertia.
        lines = [line if line[0] in "#t" else "{},{},{}".format(*(lambda t, x, f: (t, float(x) * 57.3, f))(*line.split(",")))
                 for line in (self.here / "r.csv").read_text().splitlines()]
        (self.here / "deg.csv").write_text("\n".join(lines) + "\n")
        detail = self.done("diagnose", "deg.csv").splitlines()[2]
        self.assertIn("inertia in the torque", detail)
        self.assertNotRegex(detail, r"\b(mass|force)\b")

    def test_every_command_has_the_units_of_the_axis(self):
        self.write("r.csv", REFERENCE_RADIUS_M)
        commands = {
            "fit": ("fit", "r.csv", "--effects", program.BASELINE, "--model", "r.toml"),
            "diagnose": ("diagnose", "r.csv", "--stepwise"),
            "compare": ("compare", "r.csv", "--model", "r.toml"),
            "add": ("add", "r.csv", "--model", "r.toml", "--effect", "viscous", "--out", "r2.toml"),
            "plan": ("experiment", "plan", "--for", "stribeck", "--log", "r.csv", "--model", "r.toml", "--out", "plan.csv"),
            "simulate": ("simulate", "r2.toml", "--log", "r.csv", "--end", "1", "--out", "sim.csv"),
            "demand": ("simulate", "r2.toml", "--setpoints", "plan.csv", "--out", "demand.csv"),
        }
        for name, command in commands.items():
            with self.subTest(name):
                text = self.done(*command, "--json", f"{name}.json", "--report", f"{name}.html")
                self.assert_rotary_units(text, name)
                self.assertRegex(text, r"\d [mu]?(N m|rad)")
                self.assert_rotary_json(f"{name}.json")
                page = (self.here / f"{name}.html").read_text()
                body = re.sub(r"<script.*?</script>|<style.*?</style>|<[^>]*>", " ", page, flags=re.DOTALL)
                self.assert_rotary_units(body, name)
        model = (self.here / "r2.toml").read_text()
        self.assertIn("axis = 'rotary'", model)
        self.assertIn("unit = 'N m s/rad'", model)
        self.assertIn("holdout_rmse_Nm", model)
        self.assertNotRegex(model, r"_N =|'N'|'m'|'kg'|N/m'")
        self.assertIn("time_s,position_rad,velocity_radps,acceleration_radps2", (self.here / "plan.csv").read_text())
        self.assertTrue((self.here / "sim.csv").read_text().startswith("time_s,position_rad,measured_position_rad\n"))
        self.assertTrue((self.here / "demand.csv").read_text().startswith("time_s,position_rad,torque_Nm\n"))

    def test_a_user_defined_effect_has_the_units_of_the_axis(self):
        self.write("r.csv", REFERENCE_RADIUS_M)
        text = self.done("fit", "r.csv", "--effects", program.BASELINE, "--model", "u.toml",
                         "--effect", "bump = A*exp(-((x-x0)/w)^2); A: N m; x0: rad in [0, 8]; w: rad in [0.1, 1]")
        self.assert_rotary_units(text, "user-defined")
        self.assertIn("unit = 'N m'", (self.here / "u.toml").read_text())
        self.done("compare", "r.csv", "--model", "u.toml")

    def test_files_of_two_kinds_of_axis_are_refused(self):
        self.write("r.csv", 1.0)
        fitted = self.done("fit", "r.csv", "--effects", program.BASELINE, "--model", "r.toml")
        compared = self.done("compare", "r.csv", "--model", "r.toml")
        for told in (fitted, compared):
            self.assertIn("of the torque; noise floor", told)
            self.assertNotRegex(told, r"\b1 elements\b")
        kinds = "give files of one axis"
        self.assertIn(kinds, self.refused("compare", "r.csv", "--model", "good.toml"))
        self.assertIn(kinds, self.refused("compare", "good.csv", "--model", "r.toml"))
        self.assertIn(kinds, self.refused("diagnose", "good.csv", "r.csv"))
        self.assertIn("controller works in m", self.refused("deploy", "r.toml", "--can", "vcan9", "--node", "5"))
        self.assertIn("guideways", self.refused("experiment", "models", "r.csv"))
        (self.here / "mix.csv").write_text(rotary(self.lines, 1.0).replace("position_rad", "position_m"))
        self.assertIn("give all of them for one kind of axis", self.refused("diagnose", "mix.csv"))

    @unittest.skipUnless((SHARED / "data/odrive_cogging/odrive_0p1rev.csv").exists(), "no recorded rotary log")
    def test_a_motor_that_cogs(self):
        log = SHARED / "data/odrive_cogging/odrive_0p1rev.csv"
        text = self.done("diagnose", log, "--json", "o.json", "--report", "o.html")
        self.assert_rotary_units(text, "odrive")
        result = self.assert_rotary_json("o.json")
        # Some 10 mN m of cogging on a motor of 0.045 N m/A.
        self.assertTrue(1e-4 < result["baseline"]["holdout_rmse_Nm"] < 0.05)


if __name__ == "__main__":
    program.main()
