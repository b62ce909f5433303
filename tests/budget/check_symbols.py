#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No arithmetic in double in an image: none of the library calls that a processor without double needs.

  check_symbols.py --image IMAGE.elf [...]
"""

import argparse
import re
import subprocess
import sys

import emulator

# Run-time ABI for the Arm Architecture, tables 2, 3, 5, 6, 7: functions of double, and conversions to and from it.
DOUBLE = re.compile(r"^(__aeabi_(d(add|sub|rsub|mul|div|cmp\w*)|c[dr]?dcmp\w*|[a-z0-9]+2d|d2\w+)|__\w*df[23]?)$")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", nargs="+", required=True)
    options = parser.parse_args()
    emulator.require_tool("arm-none-eabi-nm")
    failed = False
    for image in options.image:
        emulator.require(image)
        listing = subprocess.run(["arm-none-eabi-nm", image], capture_output=True, text=True, check=True).stdout
        names = [line.split()[-1] for line in listing.splitlines()]
        doubles = sorted(name for name in names if DOUBLE.match(name))
        print(f"{image}: {len(names)} symbols, {len(doubles)} of double arithmetic {' '.join(doubles)}")
        failed |= bool(doubles) or len(names) < 10
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
