# SPDX-License-Identifier: Apache-2.0
"""`slipstack commission` as typed: wrong use in one line, nothing written; one axis from nothing to compensated, killed on
the way; the emulated boards do the same. More axes: tests/bench/commission."""

import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

import program

BUILD = pathlib.Path(os.environ.get("SLIPSTACK_TARGET_BUILD", program.REPOSITORY / "build/cortex-m4"))
AXIS = ("--seed", "4", "--effects", "viscous", "--strength", "6", "--motor-reversed")


class Commission(program.Workshop):
    def assert_done_by(self, done, folder):
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, b"")
        result = program.published((self.here / f"{folder}.json").read_text())
        summary = result["summary"]
        self.assertEqual(summary["effects"][:1], ["viscous"])
        self.assertLess(summary["tracking_rms_m"], 0.4 * summary["tracking_rms_mass_alone_m"])
        self.assertGreater(summary["tracking_rms_m"], 1e-7)
        self.assertLess(summary["axis_s"], 180)
        self.assertIn("hidden: viscous", done.stdout.decode())
        self.assertIn("the motor is connected the other way round", done.stdout.decode())
        names = sorted(path.name for path in (self.here / folder).iterdir())
        for name in ("deployed.toml", "look_2.csv", "report.html", "stages.json", "test.csv", "travel.csv"):
            self.assertIn(name, names)
        self.assertFalse([name for name in names if name.endswith(".part")], names)
        return result

    def commission(self, folder, *options):
        return self.run_here("commission", *AXIS, "--out", folder, "--json", f"{folder}.json", "--reveal", *options)

    def killed_after(self, stage, *options):
        process = subprocess.Popen([program.SLIPSTACK, "commission", *AXIS, "--out", "axis", *options], cwd=self.here,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        until = time.monotonic() + program.PATIENCE_S
        stages = self.here / "axis/stages.json"
        while stage not in (json.loads(stages.read_text())["stages"] if stages.exists() else ()):
            self.assertLess(time.monotonic(), until)
            self.assertIsNone(process.poll(), "it ended before it was killed")
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=60)
        self.assertFalse((self.here / "axis/deployed.toml").exists())

    def test_a_whole_axis_killed_on_the_way(self):
        self.killed_after("mass")
        mass = json.loads((self.here / "axis/stages.json").read_text())["stages"]["mass"]
        self.killed_after("look_1")
        done = self.commission("axis")
        self.assert_done_by(done, "axis")
        self.assertEqual(json.loads((self.here / "axis/stages.json").read_text())["stages"]["mass"], mass)
        deployed = (self.here / "axis/deployed.toml").read_bytes()
        # What it deployed is a model like any other.
        self.assertEqual(self.run_here("compare", "axis/test.csv", "--model", "axis/deployed.toml").returncode, 0)
        again = self.commission("axis")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.here / "axis/deployed.toml").read_bytes(), deployed)

    def test_an_emulated_board_does_the_same_and_the_host_goes_on(self):
        image = BUILD / "bin/slipstack-mps2-an386.elf"
        if not image.exists():
            self.skipTest(f"no image {image}")
        self.killed_after("mass", "--board", "mps2-an386", "--image", str(image))
        stages = json.loads((self.here / "axis/stages.json").read_text())["stages"]
        (self.here / "axis").rename(self.here / "emulated")
        self.killed_after("mass")
        host = json.loads((self.here / "axis/stages.json").read_text())["stages"]
        for stage in ("direction", "mass"):
            self.assertEqual(stages[stage], host[stage])
        self.assert_done_by(self.commission("emulated"), "emulated")

    def test_wrong_use(self):
        self.assert_refused(["commission"], "--out")
        for arguments, expected in ((("--board", "moon"), "--board"), (("--image", "x.elf"), "--image"),
                                    (("--board", "mps2-an386", "--image", "no.elf"), "no such image"),
                                    (("--setup", "mine"), "--setup"), (("--seed", "-1"), "--seed"),
                                    (("--effects", "magic"), "--effects"), (("--strength", "nan"), "--strength"),
                                    (("--json", "no/such/folder.json"), "folder.json")):
            with self.subTest(arguments):
                self.assert_refused(["commission", "--out", "axis", *arguments], expected)

    def test_a_folder_that_is_not_its_own(self):
        (self.here / "letters").mkdir()
        (self.here / "letters" / "dear.txt").write_text("friend")
        self.assert_refused(["commission", "--out", "letters"], "no commissioning")
        (self.here / "other").mkdir()
        stages = self.here / "other" / "stages.json"
        stages.write_text(json.dumps({"format": 1, "axis": "another", "stages": {}}))
        self.assert_refused(["commission", "--out", "other"], "another axis")
        stages.write_text(json.dumps({"format": 1, "axis": "pick_and_place 1, effects none",
                                      "stages": {"direction": {"reversed": False, "axis_s": 1}, "mass": {}}}))
        self.assert_refused(["commission", "--out", "other"], "not as a commissioning writes it")
        stages.write_text("{")
        self.assert_refused(["commission", "--out", "other"], "not the record of a commissioning")


if __name__ == "__main__":
    program.main()
