#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs slipstack_test.m in Octave, in a folder with a log; status 77 and SKIP where there is no Octave."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
import program

SKIPPED = 77
PAGE = program.REPOSITORY / "docs/matlab.md"


def documented():
    """What docs/matlab.md says can be typed, in its order, with the folder of slipstack.m as it is here."""
    blocks = re.findall(r"^```matlab\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    text = "".join(blocks).replace("'workbench/matlab'", f"'{program.REPOSITORY}/workbench/matlab'")
    return text + "assert(abs(found.parameters(3).parameters(1).value / 12 - 1) < 0.1); disp('page: all ran')\n"


def run(octave, here, *options):
    done = subprocess.run(
        [octave, "--no-init-file", "--no-history", *options], cwd=here,
        env={**os.environ, "SLIPSTACK": program.SLIPSTACK, "TMPDIR": str(here / "temporary"), "HOME": str(here)},
        capture_output=True, text=True, timeout=program.PATIENCE_S)
    print(done.stdout + done.stderr)
    return done.stdout if done.returncode == 0 else ""


def main():
    octave = shutil.which("octave-cli")
    if octave is None:
        print("SKIP: Octave is not installed (package octave; toolchain/install full)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        here = pathlib.Path(folder)
        (here / "temporary").mkdir()
        program.small_log(here / "log.csv", "viscous")
        (here / "page.m").write_text(documented())
        tested = run(octave, here, "--path", str(HERE), "--path", str(program.REPOSITORY / "workbench/matlab"), "--eval",
                     "slipstack_test")
        typed = run(octave, here, "page.m")
        return 0 if "octave: all asserted" in tested and "page: all ran" in typed else 1


if __name__ == "__main__":
    sys.exit(main())
