#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`slipstack experiment` as a user sees it: tables, JSON, report page, stopping and going on, bad input."""

import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

import program

SWEEP = ["--forces-N", "3.75,12.75", "--from-Hz", "5", "--to-Hz", "50", "--points", "6"]
EXPERIMENTS = {
    "loops": (["loops", "--setup", "roller"], "loops"),
    "step": (["step"], "turning_points"),
    "free": (["free"], "turning_points"),
    "stepped-sine": (["stepped-sine", *SWEEP], "points"),
    "describing-function": (["describing-function", *SWEEP], "points"),
    "sensitivity": (["sensitivity", *SWEEP], "map"),
}


class Experiment(program.Workshop):
    @classmethod
    def setUpClass(cls):
        # No log is needed here.
        cls.stock = None

    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-test-"))
        self.addCleanup(shutil.rmtree, self.here)

    def test_each_writes_a_table_json_and_a_page(self):
        for name, (arguments, rows) in EXPERIMENTS.items():
            with self.subTest(name):
                done = self.assert_done("experiment", *arguments, "--json", "r.json", "--report", "r.html")
                text = done.stdout.decode()
                self.assertTrue(text.startswith("set-up     "), text[:80])
                result = program.published((self.here / "r.json").read_text())
                self.assertEqual(result["experiment"], name)
                self.assertIn(result["headline"], text)
                self.assertGreaterEqual(len(result[rows]), 5)
                # As many lines in the table as rows in the JSON.
                tables = sum(len(value) + 3 for value in result.values() if isinstance(value, list))
                self.assertGreaterEqual(text.count("\n"), tables)
                page = (self.here / "r.html").read_text()
                self.assertIn(result["headline"].replace("'", "&#39;")[:30], page.replace("\u00a0", " "))
                self.assertIn('data-chart="curves"', page)
                for entry in result[rows]:
                    self.assertEqual(entry.keys(), result[rows][0].keys())

    def test_threads_do_not_change_the_result(self):
        outputs = []
        for threads in ("1", "2", "5"):
            self.assert_done("experiment", "stepped-sine", *SWEEP, "--threads", threads, "--json", "r.json")
            outputs.append((self.here / "r.json").read_bytes())
        self.assertEqual(outputs[0], outputs[1])
        self.assertEqual(outputs[0], outputs[2])

    @program.long
    def test_a_stopped_sweep_goes_on_to_the_same_result(self):
        long = ["experiment", "stepped-sine", "--points", "400", "--tolerance", "1e-9", "--settled", "1e-6"]
        begin = time.monotonic()
        self.assert_done(*long, "--json", "whole.json")
        a_part_s = 0.4 * (time.monotonic() - begin)
        stops = 0
        for _ in range(40):
            run = subprocess.Popen([program.SLIPSTACK, *long, "--resume", "kept", "--json", "parts.json"], cwd=self.here,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            try:
                stdout, stderr = run.communicate(timeout=a_part_s)
            except subprocess.TimeoutExpired:
                run.send_signal(signal.SIGINT)
                stdout, stderr = run.communicate(timeout=60)
            if (self.here / "parts.json").exists():  # done, though a signal may have met the very end
                break
            if run.returncode == -signal.SIGINT:  # before the sweep began, or while its results were written
                continue
            self.assertEqual(run.returncode, 130, stderr)
            self.assertEqual(stdout, b"")
            self.assert_one_line(stderr, "stopped after", "kept in kept")
            stops += 1
        self.assertGreaterEqual(stops, 1)
        self.assertEqual((self.here / "whole.json").read_bytes(), (self.here / "parts.json").read_bytes())
        self.assertFalse((self.here / "kept").exists())

    def test_a_kept_sweep_belongs_to_its_request(self):
        long = ["experiment", "stepped-sine", "--points", "2000", "--tolerance", "1e-9"]
        for patience_s in (0.5, 1.0, 2.0, 4.0, 8.0):  # a loaded machine takes its time to begin the sweep
            run = subprocess.Popen([program.SLIPSTACK, *long, "--resume", "kept"], cwd=self.here, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
            time.sleep(patience_s)
            run.send_signal(signal.SIGINT)
            run.communicate(timeout=60)
            if run.returncode == 130:
                break
        self.assertEqual(run.returncode, 130)
        self.assert_refused([*long, "--settled", "1e-3", "--resume", "kept"], "kept: belongs to a sweep with another")
        (self.here / "kept").write_text("something else")
        self.assert_refused([*long, "--resume", "kept"], "kept: not a sweep")

    def refuse_setup(self, text, *expected, experiment=("free",)):
        (self.here / "mine.toml").write_text(text)
        self.assert_refused(["experiment", *experiment, "--setup", "mine.toml", "--json", "r.json"], *expected)

    def test_refuses_what_no_axis_can_have(self):
        base = 'based_on = "slideway"\n'
        self.refuse_setup(base + "mass_kg = -1.143\n", "mine.toml:2: mass_kg = -1.143")
        self.refuse_setup(base + "[cable_chain]\nstiffness_N_per_m = -1\n", "mine.toml:3: stiffness_N_per_m = -1")
        self.refuse_setup(base + '[[friction]]\nkind = "points"\ndisplacement_m = [1e-6, 2e-6]\nforce_N = [1, 3]\n',
                          "mine.toml:2:", "not concave")
        self.refuse_setup(base + '[[friction]]\nkind = "points"\ndisplacement_m = [1e-6, 2e-6]\nforce_N = [3, 1]\n',
                          "mine.toml:2:", "stiffness is negative")
        self.refuse_setup(base + "mas_kg = 1\n", "mine.toml:2: unknown key 'mas_kg'")
        self.refuse_setup("no toml", "mine.toml:1: not TOML")
        self.assert_refused(["experiment", "free", "--setup", "nowhere.toml"], "nowhere.toml: neither a set-up file")
        self.assert_refused(["experiment", "step", "--setup", "transducer"], "transducer: has no mass")

    def test_refuses_what_cannot_be_asked_of_an_axis(self):
        sine = ["experiment", "stepped-sine"]
        self.assert_refused([*sine, "--forces-N", "0"], "cannot move the axis")
        self.assert_refused([*sine, "--forces-N", "-3"], "cannot move the axis")
        self.assert_refused([*sine, "--forces-N", "0.3", "--sensors"], "cannot move the axis by half an encoder step")
        self.assert_refused([*sine, "--forces-N", "5000"], "at most 600 N")
        self.assert_refused([*sine, "--to-Hz", "6000"], "half the sampling rate")
        self.assert_refused([*sine, "--from-Hz", "50", "--to-Hz", "5"], "no range")
        self.assert_refused([*sine, "--from-Hz", "nan"], "no range")
        self.assert_refused(["experiment", "describing-function", "--to-Hz", "5000"], "half the sampling rate")
        self.assert_refused(["experiment", "sensitivity", "--forces-N", "0"], "cannot move the axis")
        self.assert_refused(["experiment", "step", "--force-N", "-1"], "cannot move the axis")
        self.assert_refused(["experiment", "step", "--force-N", "9"], "beyond the friction's level")
        self.assert_refused(["experiment", "free", "--release-m", "-1"], "does not move the axis")
        self.assert_refused(["experiment", "free", "--setup", "roller", "--release-m", "7"], "beyond the stroke")
        self.assert_refused(["experiment", "loops", "--amplitudes-m", "0"], "cannot move the axis")
        self.assert_refused(["experiment", "loops", "--frequency-Hz", "6000"], "half the sampling rate")
        self.assert_refused(["experiment", "loops", "--frequency-Hz", "20"], "not quasi-static")
        self.assert_refused(["experiment"], "subcommand is required")

    def test_a_set_up_can_be_printed_and_used(self):
        done = self.assert_done("experiment", "setup", "roller")
        (self.here / "mine.toml").write_bytes(done.stdout)
        one = self.assert_done("experiment", "loops", "--setup", "roller")
        other = self.assert_done("experiment", "loops", "--setup", "mine.toml")
        self.assertEqual(one.stdout, other.stdout)
        self.assert_refused(["experiment", "setup", "rollers"], "no set-up of that name")
        # No output may take the set-up's place.
        self.assert_refused(["experiment", "free", "--setup", "mine.toml", "--json", "mine.toml"], "input")


if __name__ == "__main__":
    program.main()
