#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`slipstack bode` and `tune` of a recording: a synthetic loop whose margins are known, and unusable input."""

import math
import unittest

import program

TICK_S, MASS_KG, KV, KP = 1e-4, 20.0, 3400.0, 40.0
PERIOD, LOW, HIGH = 4096, 4, 250
HEAD = f"""# tick_s: {TICK_S}
# mass_kg: {MASS_KG}
# observer_rad_per_s: 400
# position_gain_per_s: {KP}
# velocity_gain_N_s_per_m: {KV}
# integral_per_s: 40
# disturbance_share: 0
# notch_1: 0, 0.1, 0.1
# notch_2: 0, 0.1, 0.1
# velocity_mps: 0.02
# force_limit_N: 600
# motor_constant_N_per_A: 60
# band_1: 1, {PERIOD}, {LOW}, {HIGH}, force
band,capture,position_m,force_N,excitation
"""


def recording():
    """Three periods of a held force on a mass, as the drive records it: each harmonic by its own response."""
    rows = [[0.0, 0.0] for _ in range(PERIOD)]
    for line in range(LOW, HIGH + 1):
        turn = 2.0 * math.pi * line / PERIOD
        phase = -math.pi * (line - LOW) ** 2 / (HIGH - LOW)
        # x[k+1] - 2 x[k] + x[k-1] = T^2 / (2 m) (F[k] + F[k-1])
        z = complex(math.cos(turn), math.sin(turn))
        plant = TICK_S**2 / (2.0 * MASS_KG) * (z + 1.0) / (z - 1.0) ** 2
        held = 0.5 * (1.0 + 1.0 / z)
        for k in range(PERIOD):
            wave = complex(math.cos(turn * k + phase), math.sin(turn * k + phase))
            rows[k][0] += (plant * wave).real
            rows[k][1] += (held * wave).real
    lines = [f"1,1,{x:.12g},{f:.9g},{f:.9g}\n" for _ in range(3) for x, f in rows]
    return HEAD + "".join(lines)


class Bode(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.text = recording()

    def setUp(self):
        super().setUp()
        (self.here / "loop.csv").write_text(self.text)

    def test_margins_and_keys(self):
        done = self.assert_done("bode", "--log", "loop.csv", "--json", "-", "--report", "loop.html")
        result = program.published(done.stdout)
        self.assertEqual(set(result), {"schema", "experiment", "setup", "headline", "summary", "margins", "gains", "response"})
        row = result["response"][20]
        w = 2.0 * math.pi * row["frequency_Hz"]
        self.assertAlmostEqual(row["plant_m_per_N"] * MASS_KG * w * w, 1.0, delta=0.01)
        self.assertTrue(0.3 < result["margins"][0]["modulus_margin"] < 1.0)
        self.assertIn("Nyquist", (self.here / "loop.html").read_text())

    def test_tune_reaches_its_margin(self):
        for margin in ("0.5", "0.7"):
            done = self.assert_done("tune", "--log", "loop.csv", "--modulus-margin", margin, "--json", "-")
            result = program.published(done.stdout)
            predicted = [row for row in result["margins"] if row["loop"] == "predicted"][0]
            self.assertGreaterEqual(predicted["modulus_margin"], float(margin))
            self.assertLess(predicted["modulus_margin"], float(margin) + 0.15)

    def test_tune_wants_the_crossover_in_the_band(self):
        (self.here / "high.csv").write_text(self.text.replace("s_per_m: 3400.0", "s_per_m: 100.0"))
        done = self.run_here("tune", "--log", "high.csv")
        self.assertEqual(done.returncode, 2)
        self.assert_one_line(done.stderr, "--from")

    def refused(self, text, *expected):
        (self.here / "bad.csv").write_text(text)
        done = self.run_here("bode", "--log", "bad.csv", "--json", "out.json")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assert_one_line(done.stderr, *expected)
        self.assertFalse((self.here / "out.json").exists())

    def test_bad_recordings_are_refused_in_one_line(self):
        lines = self.text.splitlines(keepends=True)
        self.refused("", "bad.csv")
        self.refused("time_s,position_m\n0,0\n", "bad.csv:1")
        self.refused(self.text.replace("# mass_kg: 20.0\n", ""), "mass_kg")
        self.refused(self.text.replace("# mass_kg: 20.0", "# mass_kg: heavy"), "heavy")
        self.refused("".join(lines[:40]) + "1,1,nan,0,0\n", "bad.csv:41")
        self.refused("".join(lines[:40]) + "1,1,0\n", "bad.csv:41")
        self.refused("".join(lines[:40]) + "7,1,0,0,0\n", "band 7")
        self.refused("".join(lines[:1000]), "periods")
        self.refused(HEAD + "1,1,0,0,0\n" * 12288, "did not move")

    def test_wrong_use(self):
        for arguments in ([], ["--can", "can0", "--log", "loop.csv"], ["--log", "absent.csv"],
                          ["--log", "loop.csv", "--captures", "0"], ["--can", "no_such_bus"]):
            done = self.run_here("bode", *arguments)
            self.assertEqual(done.returncode, 2, arguments)
            self.assert_one_line(done.stderr)
        self.assertEqual(self.run_here("tune", "--log", "loop.csv", "--apply").returncode, 2)


if __name__ == "__main__":
    program.main()
