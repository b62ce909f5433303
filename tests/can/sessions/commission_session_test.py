# SPDX-License-Identifier: Apache-2.0
"""`slipstack commission` over real AF_CAN, on this kernel or in user-mode-linux, killed once on the way. On demand: it
moves the axis for two minutes of its own time, at half the pace of the clock."""

import os
import pathlib
import re
import subprocess
import sys
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SLIPSTACK = os.environ.get("SLIPSTACK", str(REPOSITORY / "build/host/bin/slipstack"))
SKIPPED = 77


class CommissionSession(unittest.TestCase):
    def test_goes_on_after_a_kill_and_stores_what_it_deployed(self):
        done = subprocess.run([REPOSITORY / "toolchain/with-can", "bash",
                               pathlib.Path(__file__).with_name("commission_session.sh"), SLIPSTACK, "4", "0.5"],
                              capture_output=True, text=True, check=False)
        if done.returncode == SKIPPED:
            print(done.stdout.strip() or "SKIP: no CAN here")
            sys.exit(SKIPPED)
        sections = dict(re.findall(r"^== (\w+)\n(.*?)(?=^== |\Z)", done.stdout, re.S | re.M))
        self.assertIn("status 0", sections["commission"], done.stdout)
        better = re.search(r"([\d.]+) times better than with its mass alone", sections["commission"])
        self.assertGreater(float(better.group(1)), 5)
        stored = re.search(r"model ([0-9a-f]{8}) and its gains are in the drive's flash", sections["commission"])
        self.assertIn(f"active {stored.group(1)}", sections["stored"])
        self.assertIn("2500h:02 Motor reversed = 1", sections["stored"])


if __name__ == "__main__":
    unittest.main()
