#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs slipstack_test.m in Octave, in a folder with a log; status 77 and SKIP where there is no Octave."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "cli"))
import program

SKIPPED = 77


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
        tested = run(octave, here, "--path", str(HERE), "--path", str(program.REPOSITORY / "workbench/matlab"), "--eval",
                     "slipstack_test")
        return 0 if "octave: all asserted" in tested else 1


if __name__ == "__main__":
    sys.exit(main())
