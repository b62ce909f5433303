#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The emulated board starts an image properly and reports how it ended.

  check_board.py --image board.elf [--wrong-fpu]
"""

import argparse
import sys

import emulator

# word: (status, what must be printed); 70 and 71: hal/mps2/semihosting.h
CASES = {
    "self-check": (0, "board: as it should be"),
    "status": (42, ""),
    "assert": (71, "assertion failed: from_flash == 0"),
    "fault": (70, "fault: exception"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--wrong-fpu", action="store_true", help="the image computes otherwise than the host: expect that it says so")
    options = parser.parse_args()
    emulator.require(options.image)
    failed = False
    if options.wrong_fpu:
        # An image that is wrong on purpose: seen, or the check above sees nothing.
        done = emulator.start(options.image, ("self-check",))
        seen = done.returncode == 1 and "rounding or denormals" in done.stdout
        print(f"{options.image}: {'seen' if seen else 'FAIL: not seen'}: {done.stdout.strip()}")
        return 0 if seen else 1
    for word, (status, text) in CASES.items():
        done = emulator.start(options.image, (word,))
        good = done.returncode == status and text in done.stdout
        failed |= not good
        print(f"{word:<12} status {done.returncode:>3}, expected {status:>3}  {'ok' if good else 'FAIL'}")
        if not good:
            print(done.stdout + done.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
