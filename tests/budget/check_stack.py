#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Deepest stack path of the control tick, from the compiler's own call graph.

  check_stack.py --graph FILE.ci [...] --root SUBSTRING --limit BYTES [--allow-indirect SUBSTRING ...]

The .ci files come from -fcallgraph-info=su: every function with its frame, every call. Adds up the deepest path from
each function whose name contains SUBSTRING, then what an exception entry pushes (26 words with the FPU's registers,
Armv7-M Architecture Reference Manual B1.5.6, and 4 bytes of alignment). Refuses recursion, frames whose size is not
known at compile time, calls through a pointer from functions that are not listed, and calls of functions that are in
no graph, but for those of the compiler's library that are known to be leaves.
"""

import argparse
import pathlib
import re
import subprocess
import sys

import emulator

EXCEPTION_FRAME = 26 * 4 + 4
# Leaves of libgcc and newlib that a tick may call; frame sizes read from their disassembly, rounded up.
LIBRARY = {"memcpy": 16, "memset": 16, "__aeabi_memcpy": 16}

NODE = re.compile(r'node: \{ title: "([^"]*)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"')


def fail(reason):
    print(f"FAIL: {reason}")
    sys.exit(1)


def read(files):
    frames, labels, calls = {}, {}, {}
    for name in files:
        with open(name) as file:
            for line in file:
                node = NODE.search(line)
                if node:
                    title, label = node.groups()
                    labels.setdefault(title, label.split("\\n")[0])
                    size = re.search(r"(\d+) bytes \((\w+(?:,\w+)?)\)", label)
                    if size:
                        if size.group(2) != "static":
                            fail(f"{labels[title]}: stack frame is {size.group(2)}, not static")
                        frames[title] = int(size.group(1))
                edge = EDGE.search(line)
                if edge:
                    calls.setdefault(edge.group(1), set()).add(edge.group(2))
    # GCC names a part of a function that it has split off "0(...)": its name is that of the function.
    for title, label in labels.items():
        if re.match(r"\d+\(", label):
            symbol = title.split(":")[-1].split(".")[0]
            labels[title] = subprocess.run(["c++filt", symbol], capture_output=True, text=True, check=True).stdout.strip()
    return frames, labels, calls


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graph", nargs="+", required=True)
    parser.add_argument("--root", required=True)
    parser.add_argument("--limit", type=int, required=True)
    parser.add_argument("--allow-indirect", action="append", default=[])
    options = parser.parse_args()
    for graph in options.graph:
        if not pathlib.Path(graph).is_file():
            emulator.require_tool("arm-none-eabi-g++")
            fail(f"{graph} is missing: build the cortex-m4 preset")
    frames, labels, calls = read(options.graph)
    known = {}

    def deepest(title, path):
        """(bytes, path) of the deepest way down from this function."""
        if title in path:
            fail("recursion: " + " -> ".join(labels.get(t, t) for t in [*path, title]))
        if title in known:
            return known[title]
        if title == "__indirect_call":
            caller = labels.get(path[-1], path[-1])
            if not any(allowed in caller for allowed in options.allow_indirect):
                fail(f"{caller} calls through a pointer and is not listed")
            return 0, []
        if title not in frames:
            if title in LIBRARY:
                return LIBRARY[title], [title]
            fail(f"{labels.get(path[-1], path[-1])} calls {title}, whose stack nobody knows")
        below = max((deepest(t, [*path, title]) for t in calls.get(title, ())), default=(0, []))
        known[title] = (frames[title] + below[0], [title, *below[1]])
        return known[title]

    roots = [t for t in frames if options.root in labels[t]]
    if not roots:
        fail(f"no function contains '{options.root}'")
    size, path = max(deepest(t, []) for t in roots)
    print(f"{'stack of the tick, bytes':<90}{'frame':>7}")
    for title in path:
        print(f"  {labels.get(title, title)[:86]:<88}{frames.get(title, LIBRARY.get(title, 0)):>7}")
    print(f"  {'exception entry with FPU registers':<88}{EXCEPTION_FRAME:>7}")
    total = size + EXCEPTION_FRAME
    print(f"{'sum':<90}{total:>7}   limit {options.limit}")
    if total > options.limit:
        fail(f"{total} bytes are more than {options.limit}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
