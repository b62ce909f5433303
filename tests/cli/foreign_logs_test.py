#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files of other programs (tests/data/foreign, made by pandas, Octave, LibreOffice and TwinCAT Scope) become logs with the same numbers, or one
line says what to do with them."""

import json
import math
import unittest

import program

FOREIGN = program.REPOSITORY / "tests/data/foreign"
# What make_with_pandas.py and make_with_octave.m have written.
COUNT, STEP_S, MIDDLE_M, STROKE_M, FREQUENCY_HZ = 1200, 0.002, 0.0125, 0.003, 1.5


class ForeignLogs(program.Workshop):
    def imported(self, name, *options):
        done = self.assert_done("import", FOREIGN / name, "--out", "log.csv", *options)
        lines = (self.here / "log.csv").read_text().splitlines()
        head, *rows = [line for line in lines if not line.startswith("#")]
        columns = dict(zip(head.split(","), zip(*([float(field) for field in row.split(",")] for row in rows))))
        return done.stdout.decode(), lines, columns

    def assert_motion(self, columns, tolerance_s=2e-7):
        unit_m = {"position_m": 1.0, "position_mm": 1e-3}
        name = next(key for key in columns if key.startswith("position_"))
        self.assertEqual(len(columns["time_s"]), COUNT)
        for i, (time_s, position) in enumerate(zip(columns["time_s"], columns[name])):
            self.assertAlmostEqual(time_s, i * STEP_S, delta=tolerance_s)
            expected_m = MIDDLE_M + STROKE_M * math.sin(2.0 * math.pi * FREQUENCY_HZ * i * STEP_S)
            self.assertAlmostEqual(position * unit_m[name], expected_m, delta=6e-8)
        self.assertEqual(len(columns["force_N"]), COUNT)

    def test_tables_of_text(self):
        for name in ("pandas_german.csv", "pandas_dates.tsv", "pandas_ns.csv", "libreoffice.csv"):
            with self.subTest(name):
                text, lines, columns = self.imported(name)
                self.assert_motion(columns)
                self.assertNotIn("note", text)
                self.assertFalse([line for line in lines if "irregular" in line])

    def test_without_names(self):
        _, _, columns = self.imported("octave_dlmwrite.txt", "--columns", "1=time_s,2=position_m,3=force_N")
        self.assert_motion(columns)

    def test_jitter_is_said_and_the_log_is_read(self):
        text, lines, columns = self.imported("pandas_jitter.csv")
        self.assertIn("time stamps are uneven", text)
        self.assertEqual(lines[0], "# sampling: irregular")
        self.assertGreater(max(abs(t - i * STEP_S) for i, t in enumerate(columns["time_s"])), 1e-4)
        self.assert_done("fit", "log.csv", "--effects", "inertia,coulomb")

    def test_scope_of_twincat(self):
        # The ramps that its author recorded: each channel counts its samples of 1 ms.
        for name, count in (("scope_channels.csv", 90), ("scope_groups.csv", 150)):
            with self.subTest(name):
                text, _, columns = self.imported(name, "--columns", "var_REAL64=position_um,func_scaled=force_N")
                self.assertNotIn("note", text)
                self.assertEqual(columns["position_um"], tuple(float(i) for i in range(count)))
                self.assertEqual(columns["force_N"], tuple(1.0 - i for i in range(count)))
                for i, time_s in enumerate(columns["time_s"]):
                    self.assertAlmostEqual(time_s, i * 1e-3, delta=1e-12)

    def test_channels_of_a_scope_with_different_sample_times(self):
        for other in ("var_REAL64", "func_freesample"):
            self.assert_refused(["import", FOREIGN / "scope_groups.csv", "--out", "mixed.csv", "--columns",
                                 f"func_OS=position_um,{other}=force_N"], "scope_groups.csv", "not sampled together")

    def test_mat_of_octave_is_a_log(self):
        self.assert_done("fit", FOREIGN / "octave_v7.mat", "--effects", "inertia,coulomb")

    def test_mat_of_version_7_3_is_a_log(self):
        done = self.run_here("fit", FOREIGN / "hdf5storage_v73.mat", "--effects", "inertia,coulomb", "--json", "-")
        if b"libhdf5" in done.stderr:
            self.skipTest(done.stderr.decode())
        old = self.assert_done("fit", FOREIGN / "octave_v7.mat", "--effects", "inertia,coulomb", "--json", "-")
        result, same = json.loads(done.stdout), json.loads(old.stdout)
        # The same motion, but for the rounding of two libraries' sines.
        self.assertEqual(result["samples"], same["samples"])
        self.assertAlmostEqual(result["train_rmse_N"], same["train_rmse_N"], delta=1e-6)

    def test_other_formats_say_what_to_do(self):
        for name, told in (("pandas.xlsx", "save its sheet as CSV"), ("libreoffice.ods", "save its sheet as CSV"),
                           ("candump.log", "slipstack.candump")):
            self.assert_refused(["import", FOREIGN / name, "--out", "log.csv"], name, told)
            self.assert_refused(["diagnose", FOREIGN / name], name, told)
        self.assert_refused(["diagnose", FOREIGN / "octave.h5"], "octave.h5", "-v7")
        self.assert_refused(["import", FOREIGN / "octave_v7.mat", "--out", "log.csv"], "every command reads as it is")

    def test_a_column_that_is_missing_is_said_with_those_that_there_are(self):
        self.assert_refused(["import", FOREIGN / "scope_channels.csv", "--out", "log.csv"], "no column is the position",
                            "--columns 'NAME=position_mm*FACTOR'", "'var_REAL64'", "'func_scaled'")
        self.assert_refused(["import", FOREIGN / "scope_channels.csv", "--out", "log.csv", "--columns",
                             "var_REAL64=position_um,func_scaled=current_A"], "--header motor_constant_N_per_A=VALUE")
        # The names that it tells can be used.
        self.assert_refused(["import", FOREIGN / "octave_dlmwrite.txt", "--out", "log.csv"], "--header sample_rate_Hz", "'column 1'")
        _, _, columns = self.imported("octave_dlmwrite.txt", "--columns", "column 1=time_s,column 2=position_m,column 3=force_N")
        self.assert_motion(columns)

    def test_without_time_but_with_a_rate(self):
        _, _, columns = self.imported("octave_dlmwrite.txt", "--columns", "2=position_m,3=force_N", "--header", "sample_rate_Hz=500")
        self.assert_motion(columns)
        for rate in ("0", "-500", "fast", "500Hz"):
            self.assert_refused(["import", FOREIGN / "octave_dlmwrite.txt", "--out", "new.csv", "--columns", "2=position_m,3=force_N",
                                 "--header", f"sample_rate_Hz={rate}"], "sample_rate_Hz", rate)

    def test_header_lines_of_a_log_are_kept(self):
        _, lines, columns = self.imported("candump_record.csv")
        self.assertIn("# motor_constant_N_per_A: 60", lines)
        self.assertEqual(len(columns["position_counts"]), len((FOREIGN / "candump_record.csv").read_text().splitlines()) - 6)
        _, lines, _ = self.imported("candump_record.csv", "--header", "motor_constant_N_per_A=61")
        self.assertEqual([line for line in lines if "motor_constant" in line], ["# motor_constant_N_per_A: 61"])


if __name__ == "__main__":
    program.main()
