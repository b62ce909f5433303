#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Configures and builds the cortex-m4 preset, so that the checks measure the sources as they are.

  build_target.py --source DIR --build DIR
"""

import argparse
import subprocess
import sys

import emulator


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", required=True)
    parser.add_argument("--build", required=True)
    options = parser.parse_args()
    emulator.require_tool("arm-none-eabi-g++")
    for command in (
        ["cmake", "--preset", "cortex-m4", "-B", options.build],
        ["cmake", "--build", options.build],
    ):
        done = subprocess.run(command, cwd=options.source, capture_output=True, text=True)
        if done.returncode != 0:
            print(done.stdout + done.stderr)
            emulator.fail(" ".join(command))
    return 0


if __name__ == "__main__":
    sys.exit(main())
