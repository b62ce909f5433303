# SPDX-License-Identifier: Apache-2.0
"""Node and commands over real AF_CAN, on this kernel or in user-mode-linux; tshark reads the capture."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "tests/cli"), str(REPOSITORY / "tests/can/description_files")]
from user_effect_test import SNAG, hide_snag  # noqa: E402
SLIPSTACK = os.environ.get("SLIPSTACK", str(REPOSITORY / "build/host/bin/slipstack"))
SLIPSTACK_SIM = os.environ.get("SLIPSTACK_SIM", str(REPOSITORY / "build/host/bin/slipstack-sim"))
SKIPPED = 77


def skip(reason):
    print(f"SKIP: {reason}")
    sys.exit(SKIPPED)


def model_in(folder):
    """A model that was fitted to a simulated log."""
    log, model = folder / "good.csv", folder / "good.toml"
    subprocess.run([SLIPSTACK_SIM, "log", "--setup", "pick_and_place", "--seed", "1", "--out", log, "--truth",
                    folder / "truth", "--effects", "viscous", "--seconds", "8", "--rate", "500", "--strength", "10"],
                   check=True, capture_output=True)
    subprocess.run([SLIPSTACK, "fit", log, "--effects", "inertia,presliding_hysteresis,viscous", "--model", model],
                   check=True, capture_output=True)
    return model


def own_model_in(folder):
    """A model with an effect of the user's own: hidden in a simulated log, named by the diagnosis, added."""
    clean, log, base, model = (folder / name for name in ("clean.csv", "snag.csv", "base.toml", "snag.toml"))

    def run(*arguments):
        return subprocess.run([SLIPSTACK, *arguments], check=True, capture_output=True, text=True).stdout

    subprocess.run([SLIPSTACK_SIM, "log", "--setup", "pick_and_place", "--seed", "3", "--out", clean, "--truth",
                    folder / "truth", "--effects", "none", "--seconds", "20", "--rate", "1000"],
                   check=True, capture_output=True)
    hide_snag(clean, log, 4.0, 0.21, 0.004)
    if "Missing: snag" not in run("diagnose", log, "--effect", SNAG):
        raise RuntimeError("the diagnosis does not name what was hidden")
    run("fit", log, "--effects", "inertia,presliding_hysteresis", "--model", base)
    if "controller snag as a table" not in run("add", log, "--model", base, "--effect", SNAG, "--out", model):
        raise RuntimeError("the user-defined effect got no table")
    return model


def session(folder):
    """What the session printed, by section."""
    model = own_model_in(folder)
    done = subprocess.run([REPOSITORY / "toolchain/with-can", "bash",
                           pathlib.Path(__file__).with_name("socketcan_session.sh"), SLIPSTACK, model],
                          capture_output=True, text=True, timeout=570)
    if done.returncode == SKIPPED:
        skip(done.stdout.strip().removeprefix("SKIP: "))
    parts = re.split(r"^== (\w+)\n", done.stdout, flags=re.M)
    return dict(zip(parts[1::2], parts[2::2]))


def check_capture(test, path, capture, fewest, kinds):
    """tshark's CANopen dissector reads every frame, and these kinds of messages."""
    if shutil.which("tshark") is None:
        test.skipTest("tshark is not installed")
    path.write_text(capture)
    done = subprocess.run(["tshark", "-r", path, "-d", "can.subdissector,canopen", "-T", "fields", "-e",
                           "_ws.col.Protocol", "-e", "_ws.col.Info", "-e", "_ws.malformed"],
                          capture_output=True, text=True)
    test.assertEqual(done.returncode, 0, done.stderr)
    rows = [line.split("\t") for line in done.stdout.splitlines()]
    test.assertGreater(len(rows), fewest)
    test.assertEqual([row for row in rows if len(row) > 2 and row[2]], [])
    info = " ".join({row[1] for row in rows if row[0] == "CANopen"})
    for kind in kinds:
        test.assertIn(kind, info)


class SocketCan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-can-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.said = session(cls.folder)

    def test_status(self):
        self.assertIn("switch on disabled", self.said["status"])

    def test_deploy_and_store(self):
        self.assertIn("read back the same", self.said["deploy"])
        self.assertIn("stored     yes", self.said["deploy"])
        deployed = re.search(r"hash ([0-9a-f]{8})", self.said["deploy"])[1]
        self.assertIn(f"active {deployed}", self.said["stored"])

    def test_record(self):
        self.assertIn("samples    500", self.said["record"])
        self.assertTrue(self.said["record"].endswith("\n500\n"), self.said["record"])
        # By the kernel's stamps; how late frames come depends on what else this machine does.
        self.assertRegex(self.said["record"], r"arrival +within [\d.]+ ms of the drive's clock")
        self.assertTrue(self.said["trace"].endswith("\n4096\n"), self.said["trace"])

    def test_refusals_are_one_line_and_status_2(self):
        lines = self.said["refused"].splitlines()
        self.assertEqual(len(lines), 4, lines)
        self.assertIn("does not answer", lines[0])
        self.assertEqual(lines[1], "status 2")
        self.assertIn("no such interface", lines[2])
        self.assertEqual(lines[3], "status 2")

    def test_misuse_is_one_line_status_2_and_nothing_half_written(self):
        lines = self.said["misused"].splitlines()
        expected = ("wrong.toml", "none.toml", "node 9 does not answer", "none/log.csv", "node 9 does not answer",
                    "no such interface", "--seconds", "--rate", "no such interface", "nothing_known", "not the flash",
                    "enabled; disable", "the access lock is closed")
        for line, what in zip(lines, expected):
            self.assertTrue(line.startswith("status 2 lines 1: slipstack: "), line)
            self.assertIn(what, line)
        self.assertEqual(lines[len(expected):],
                         ["lock       locked", "model and store as before", "no log left"])

    def test_update(self):
        lines = self.said["update"].splitlines()
        self.assertRegex(lines[0], r"^program    1\.0, 30004 bytes, CRC [0-9a-f]{8}$")
        self.assertEqual(lines[1:3], ["slot       2", "state      has reported in, confirmed"])
        again = lines[0].replace("30004 bytes, ", "") + ": runs already"
        self.assertEqual(lines[3], again)
        expected = ("for another product or board", "not an update file", "cannot be read", "node 9 does not answer",
                    "the new program did not report in; the one before is back")
        for line, what in zip(lines[4:], expected):
            self.assertTrue(line.startswith("status 2 lines 1: slipstack: "), line)
            self.assertIn(what, line)
        self.assertEqual(lines[4 + len(expected):], [again], "what ran before runs")

    def test_workbench(self):
        """Watched, recorded, deployed, moved: what the page in the browser does with a controller on a bus."""
        try:
            said = json.loads(self.said["workbench"])
        except json.JSONDecodeError:
            self.fail(self.said["workbench"])
        self.assertIn("vcan0", said["interfaces"])
        self.assertIn("no such interface", said["no_such_bus"])
        self.assertRegex(said["status"], r"node +5 on vcan0")
        self.assertGreater(said["messages"], 3)
        self.assertGreater(said["samples"], 100)
        self.assertEqual(said["steps_s"], [0.01])
        self.assertIn("the travel must be between", said["travel_refused"])
        self.assertEqual(said["deploy"][:2], ["done", ""])
        self.assertIn("read back the same", said["deploy"][2])
        # What was on the node is this model: the move is followed as before, and nothing differs.
        self.assertEqual([said["differences"], said["differences_after"]], [0, []])
        for rms_m in said["tracking_rms_m"]:
            self.assertTrue(1e-8 < rms_m < 1e-3, said["tracking_rms_m"])
        self.assertEqual([part["label"] for part in said["parts"]], ["the model that was there", "version 1"])
        for part in said["parts"]:
            self.assertTrue(0.1 < part["moving_s"] < 10, part)
        # It is the longest part without a gap, of the second recording where the first had too little of the move.
        self.assertRegex(said["logs"][-1]["name"], r"^node5(-\d)?\.csv$", said)
        self.assertAlmostEqual(said["logs"][-1]["sample_rate_Hz"], 100, places=6)
        self.assertEqual(said["opened"], ["done", "", True])
        self.assertIsNone(said["left"])

    def test_foreign_frames(self):
        self.assertIn("node ends with 0", self.said["foreign"])
        capture = self.said["capture"]
        self.assertRegex(capture, r"705#00\n")
        self.assertRegex(capture, r"585#4300100092010200\n")
        # The table of the user-defined effect is on, as any master reads it.
        self.assertRegex(capture, r"585#4F12210101000000\n")
        self.assertRegex(capture, r"085#1082")

    def test_error_frames_are_bus_off_and_its_end(self):
        # Recovered from bus-off; the error of the short PDO is still there, so the next message reports that one.
        self.assertEqual(re.findall(r"085#(?:4081|1082)\w{12}", self.said["capture"]),
                         ["085#1082110305020000", "085#4081110100000000", "085#1082110100000000"])
        # The first heartbeat afterwards, whatever comes before it.
        after = re.search(r"085#4081.*\n(?:(?!.*705#).*\n)*.*705#(\w\w)", self.said["capture"])
        self.assertEqual(after[1], "7F", after[0])

    def test_tshark_finds_nothing_malformed(self):
        check_capture(self, self.folder / "capture.log", self.said["capture"], 2000,
                      ("SDO", "PDO", "EMCY", "NMT", "SYNC"))


if __name__ == "__main__":
    unittest.main()
