# SPDX-License-Identifier: Apache-2.0
"""The firmware image in the emulator on slcan0: UART, SLCAN, slcand, AF_CAN, candump, and the commands."""

import contextlib
import os
import pathlib
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tty
import unittest

import socketcan_test
from eds import Eds

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("SLIPSTACK_TARGET_BUILD", socketcan_test.REPOSITORY / "build/cortex-m4"))


@contextlib.contextmanager
def emulated(flash):
    """The emulated board with this flash; the terminal that its CAN is on."""
    process = subprocess.Popen([socketcan_test.SLIPSTACK, "node", "--board", "mps2-an386", "--image",
                                BUILD / "bin/slipstack-mps2-an386.elf", "--node", "5", "--flash", flash],
                               stdout=subprocess.PIPE, text=True)
    try:
        process.stdout.readline()
        yield re.search(r"SLCAN on (/dev/\S+):", process.stdout.readline())[1]
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(10)
        process.stdout.close()


def first_frame(terminal, pattern, patience_s=30):
    """What comes on a terminal up to this pattern."""
    line = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
    received = ""
    try:
        tty.setraw(line)
        until = time.monotonic() + patience_s
        while time.monotonic() < until and not re.search(pattern, received):
            if select.select([line], [], [], 0.2)[0]:
                received += os.read(line, 4096).decode("ascii", "replace")
    finally:
        os.close(line)
    return received


def model_bytes():
    """The size of the model image 2141h: four bytes for every row of an effect but its first."""
    eds = Eds((socketcan_test.REPOSITORY / "docs/slipstack.eds").read_text(encoding="ascii"))
    rows = [key for key in eds.objects if 0x2100 <= key[0] < 0x2140 and key[1] > 0]
    return (4 * len(rows)).to_bytes(4, "little")


def session(folder, terminal):
    model = socketcan_test.model_in(folder)
    done = subprocess.run([socketcan_test.REPOSITORY / "toolchain/with-can", "--serial", terminal, "bash",
                           HERE / "emulated_session.sh", socketcan_test.SLIPSTACK, model, model_bytes().hex().upper()],
                          capture_output=True, text=True, timeout=570)
    if done.returncode == socketcan_test.SKIPPED:
        socketcan_test.skip(done.stdout.strip().removeprefix("SKIP: "))
    parts = re.split(r"^== (\w+)\n", done.stdout, flags=re.M)
    return dict(zip(parts[1::2], parts[2::2]))


class EmulatedController(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if shutil.which("qemu-system-arm") is None:
            socketcan_test.skip("qemu-system-arm is not installed")
        if not (BUILD / "bin/slipstack-mps2-an386.elf").is_file():
            socketcan_test.skip("no image of the emulated board; cmake --build --preset cortex-m4")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-emulated-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        with emulated(cls.folder / "flash") as terminal:
            cls.said = session(cls.folder, terminal)

    def test_lss_gives_it_another_id(self):
        capture = self.said["capture"]
        self.assertRegex(capture, r"7E4#1100000000000000\n")
        self.assertRegex(capture, r"7E4#1700000000000000\n")
        self.assertRegex(capture, r"706#00\n")
        self.assertIn("node       6 on slcan0", self.said["status"])

    def test_deploys_and_stores(self):
        self.assertIn("read back the same", self.said["deploy"])
        self.assertIn("stored     yes", self.said["deploy"])

    def test_moves_the_axis(self):
        self.assertIn("operation enabled", self.said["moved"])
        before = int(re.search(r"position +(-?\d+)", self.said["status"])[1])
        after = int(re.search(r"position +(-?\d+)", self.said["moved"])[1])
        self.assertAlmostEqual(before, 200000, delta=200)
        self.assertAlmostEqual(after, 0x37530, delta=200)

    def test_records(self):
        self.assertIn("samples    4096, 0 lost", self.said["trace"])
        self.assertTrue(self.said["trace"].endswith("\n4096\n"), self.said["trace"][-200:])
        self.assertIn("# mass_kg: 35.4", self.said["trace"])
        self.assertIn("samples    200", self.said["record"])
        self.assertTrue(self.said["record"].endswith("\n200\n"), self.said["record"][-200:])

    def test_refuses_a_model_while_enabled(self):
        self.assertRegex(self.said["refused"], r"^slipstack: .*enabled.*\nstatus 2\n$")

    def test_survives_a_master_that_dies_in_a_block(self):
        deployed = re.search(r"hash ([0-9a-f]{8})", self.said["deploy"])[1]
        self.assertIn(f"active {deployed}, staged {deployed}", self.said["foreign"])
        # A remote request and a 29-bit identifier have no answer; the dead master is told 0504 0000h.
        capture = self.said["capture"]
        self.assertRegex(capture, r"586#8041210000000405\n")
        after_request = capture.split("606#R\n", 1)[1]
        self.assertNotIn("586#", re.split(r" 606#", after_request, maxsplit=1)[0])

    def test_what_was_stored_is_there_after_a_power_cycle(self):
        with emulated(self.folder / "flash") as terminal:
            self.assertRegex(first_frame(terminal, r"t7061(00|7F)\r"), r"t7061(00|7F)\r")

    def test_tshark_finds_nothing_malformed(self):
        socketcan_test.check_capture(self, self.folder / "capture.log", self.said["capture"], 1000,
                                     ("SDO", "NMT", "SYNC", "PDO"))


if __name__ == "__main__":
    if sys.argv[1:] == ["--print"]:
        with tempfile.TemporaryDirectory() as here, emulated(pathlib.Path(here) / "flash") as pts:
            for name, text in session(pathlib.Path(here), pts).items():
                print(f"== {name}\n{text}", end="")
    else:
        unittest.main()
