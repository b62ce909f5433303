#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The linker refuses an image with a heap, and names the reason.

  check_no_heap.py --build DIR

That the ordinary images link shows that they have none; that these do not link shows that the check can fail.
"""

import argparse
import subprocess
import sys

import emulator


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True)
    options = parser.parse_args()
    emulator.require_tool("arm-none-eabi-g++")
    for target in ("heap_probe_malloc", "heap_probe_new"):
        done = subprocess.run(
            ["cmake", "--build", options.build, "--target", target], capture_output=True, text=True
        )
        if done.returncode == 0:
            emulator.fail(f"{target} links, although it uses the heap")
        if "heap: the image must not contain" not in done.stdout + done.stderr:
            print(done.stdout + done.stderr)
            emulator.fail(f"{target} does not link, but for another reason")
        print(f"{target:<20} refused by the linker, as it must be")
    return 0


if __name__ == "__main__":
    sys.exit(main())
