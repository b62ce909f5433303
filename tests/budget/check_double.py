#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Arithmetic in double only where it is listed: by the compiler's own call graph, from -fcallgraph-info.

  check_double.py --graph FILE.ci [...] --allow SUBSTRING [...]

Every function that calls the library for double (the processor has none) must contain one of the substrings in its
name, and each substring must be found. That the tick reaches none of them is check_stack.py's to say, which knows every
library function that the tick may call.
"""

import argparse
import pathlib
import re
import sys

import check_stack
import emulator

# Run-time ABI for the Arm Architecture, tables 2, 3, 5, 6, 7: functions of double, and conversions to and from it.
DOUBLE = re.compile(r"^(__aeabi_(d(add|sub|rsub|mul|div|cmp\w*)|c[dr]?dcmp\w*|[a-z0-9]+2d|d2\w+)|__\w*df[23]?)$")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graph", nargs="+", required=True)
    parser.add_argument("--allow", nargs="*", default=[])
    options = parser.parse_args()
    for graph in options.graph:
        if not pathlib.Path(graph).is_file():
            emulator.require_tool("arm-none-eabi-g++")
            check_stack.fail(f"{graph} is missing: build the cortex-m4 preset")
    _, labels, calls = check_stack.read(options.graph)
    callers = sorted({labels.get(who, who) for who, called in calls.items() if any(DOUBLE.match(c) for c in called)})
    for caller in callers:
        print(caller)
    others = [c for c in callers if not any(allowed in c for allowed in options.allow)]
    unused = [allowed for allowed in options.allow if not any(allowed in c for c in callers)]
    for caller in others:
        print(f"FAIL: arithmetic in double in {caller}")
    for allowed in unused:
        print(f"FAIL: nothing in double in {allowed}: take it off the list")
    return 1 if others or unused else 0


if __name__ == "__main__":
    sys.exit(main())
