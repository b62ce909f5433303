# SPDX-License-Identifier: Apache-2.0
"""`slipstack loop`: the firmware around the simulated axis, in this process and on the emulated boards."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import program

BUILD = pathlib.Path(os.environ.get("SLIPSTACK_TARGET_BUILD", program.REPOSITORY / "build/cortex-m4"))
BOARDS = ("mps2-an386", "mps2-an500")


def image(board):
    return BUILD / "bin" / f"slipstack-{board}.elf"


def child_of(process):
    """The emulator that this process has started, waited for."""
    until = time.monotonic() + 30
    while time.monotonic() < until:
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
        words = children.read_text().split() if children.exists() else []
        if words:
            return int(words[0])
        time.sleep(0.01)
    raise AssertionError("no emulator was started")


def gone(pid):
    until = time.monotonic() + 10
    while time.monotonic() < until:
        try:
            state = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False


class Loop(unittest.TestCase):
    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-loop-"))
        self.addCleanup(shutil.rmtree, self.here)

    def loop(self, *arguments):
        return program.run("loop", *arguments, cwd=self.here)

    def assert_one_line(self, done, status, *expected):
        line = done.stderr.decode()
        self.assertEqual(done.returncode, status, line)
        self.assertEqual(line.count("\n"), 1, line)
        self.assertTrue(line.startswith("slipstack: "), line)
        self.assertNotIn("internal fault", line)
        for text in expected:
            self.assertIn(text, line)
        self.assertEqual(done.stdout, b"")
        self.assertEqual(list(self.here.iterdir()), [])

    def need(self, board):
        if shutil.which("qemu-system-arm") is None or not image(board).is_file():
            self.skipTest(f"no emulator or no image {image(board)}")

    def test_the_log_is_one_that_diagnose_reads_and_explains(self):
        done = self.loop("--seconds", "20", "--effects", "viscous", "--out", "log.csv", "--json", "loop.json")
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        told = program.published((self.here / "loop.json").read_text())
        self.assertEqual(told["fault"], "")
        self.assertEqual(told["overruns"], 0)
        self.assertGreater(told["ticks"], 190000)
        # A few micrometres: without compensation the error at reversals is tens of them, not hundreds.
        self.assertGreater(told["rms_error_m"], 1e-6)
        self.assertLess(told["rms_error_m"], 5e-5)
        done = program.run("diagnose", "log.csv", "--json", "found.json", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads((self.here / "found.json").read_text())
        self.assertEqual(found["verdict"], "missing_effect")
        self.assertEqual(found["candidates"][0]["effect"], "viscous")

    def test_nothing_is_missing_where_nothing_is_hidden_and_the_model_makes_the_axis_follow(self):
        self.assertEqual(self.loop("--seconds", "20", "--out", "log.csv", "--json", "without.json").returncode, 0)
        done = program.run("diagnose", "log.csv", "--json", "found.json", cwd=self.here)
        self.assertEqual(json.loads((self.here / "found.json").read_text())["verdict"], "complete", done.stdout)
        fitted = program.run("fit", "log.csv", "--effects", program.BASELINE, "--model", "m.toml", cwd=self.here)
        self.assertEqual(fitted.returncode, 0, fitted.stderr)
        done = self.loop("--seconds", "20", "--model", "m.toml", "--json", "with.json")
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        without, with_it = (json.loads((self.here / name).read_text()) for name in ("without.json", "with.json"))
        ratio = with_it["rms_reversal_error_m"] / without["rms_reversal_error_m"]
        self.assertLess(ratio, 0.3)
        self.assertGreater(ratio, 0.005)
        self.assertNotEqual(with_it["model_hash"], without["model_hash"])
        self.assertIn(with_it["model_hash"], (self.here / "m.toml").read_text())

    def test_emulated_boards_write_the_same_log_as_the_host(self):
        self.assertEqual(self.loop("--seconds", "8", "--effects", "force_ripple", "--out", "host.csv").returncode, 0)
        for board in BOARDS:
            with self.subTest(board):
                self.need(board)
                done = self.loop("--board", board, "--image", image(board), "--seconds", "8", "--effects",
                                 "force_ripple", "--out", f"{board}.csv")
                self.assertEqual((done.returncode, done.stderr), (0, b""))
                self.assertEqual((self.here / f"{board}.csv").read_bytes(), (self.here / "host.csv").read_bytes())

    def test_a_killed_emulator_is_one_line_and_nothing_is_left(self):
        self.need("mps2-an386")
        process = subprocess.Popen(
            [program.SLIPSTACK, "loop", "--board", "mps2-an386", "--image", image("mps2-an386"), "--seconds", "3600",
             "--out", "log.csv"],
            cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        os.kill(child_of(process), signal.SIGKILL)
        out, err = process.communicate(timeout=60)
        done = subprocess.CompletedProcess([], process.returncode, out, err)
        # Killed before or after the first tick: either is one line.
        self.assertIn(done.returncode, (1, 2))
        self.assert_one_line(done, done.returncode, "killed by signal 9")

    def test_a_killed_loop_takes_its_emulator_along(self):
        self.need("mps2-an386")
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen(
                [program.SLIPSTACK, "loop", "--board", "mps2-an386", "--image", image("mps2-an386"), "--seconds",
                 "3600", "--out", "log.csv"],
                cwd=self.here, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            emulator = child_of(process)
            process.send_signal(number)
            process.wait(timeout=60)
            self.assertTrue(gone(emulator), f"signal {number}")

    def test_a_plant_that_diverges(self):
        self.assert_one_line(self.loop("--seconds", "8", "--push", "1e9", "--out", "log.csv"), 1, "the plant diverges")

    def test_a_push_beyond_the_motor_ends_in_a_fault_and_says_so(self):
        done = self.loop("--seconds", "8", "--push", "2e3", "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(program.published(done.stdout)["fault"], ("8611", "7121"))

    def test_wrong_use(self):
        for arguments, expected in (
            (("--board", "mps3"), "is none of host, mps2-an386, mps2-an500"),
            (("--board", "mps2-an386", "--image", "no.elf"), "no such image; build it"),
            (("--image", "no.elf"), "there is none on --board host"),
            (("--seconds", "1"), "between 8 and 3600"),
            (("--seconds", "nan"), "between 8 and 3600"),
            (("--log-rate", "3000"), "must be a multiple"),
            (("--log-rate", "0"), "between 100 and 10000"),
            (("--seed", "-1"), "must not be negative"),
            (("--setup", "crane"), "neither pick_and_place nor random"),
            (("--effects", "inertia"), "no effect that an axis can be given"),
            (("--effects", "magic"), "no effect that an axis can be given"),
            (("--model", "no.toml"), "no.toml"),
            (("--push", "inf"), "must be a number"),
            (("--out", "no/such/folder.csv"), "folder.csv"),
        ):
            with self.subTest(arguments):
                self.assert_one_line(self.loop("--out", "log.csv", *arguments) if "--out" not in arguments
                                     else self.loop(*arguments), 2, expected)

    def test_without_the_emulator(self):
        self.need("mps2-an386")
        done = subprocess.run(
            [program.SLIPSTACK, "loop", "--board", "mps2-an386", "--image", image("mps2-an386"), "--out", "log.csv"],
            cwd=self.here, env={"PATH": "/nowhere"}, capture_output=True, timeout=60)
        self.assert_one_line(done, 2, "install the package qemu-system-arm")


if __name__ == "__main__":
    program.main()
