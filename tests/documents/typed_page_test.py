#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the pages say can be typed does what they say.

    typed_page_test.py PAGE...   types the commands of a page, in their order, and compares what the page shows
    typed_page_test.py --listed  what is not typed (fixtures.NOT_TYPED), and whether each entry still has its command
    typed_page_test.py --pages   the pages with something to type or to compare, a line each, `can` before those that need a bus
"""

import json
import pathlib
import re
import shlex
import subprocess
import sys

import commands
import fixtures
import markdown
import session
from fixtures import program

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
MOST_NOT_TYPED = 16


def pages():
    return [page for page in markdown.pages() if any(commands.commands(page))]


def tests_of_ctest():
    """The names that CTest knows; those of programs that are not built end in _NOT_BUILT."""
    done = subprocess.run(["ctest", "--test-dir", session.BUILD, "-N"], capture_output=True, text=True)
    return re.findall(r"^ *Test +#\d+: (\S+)$", done.stdout, re.MULTILINE)


def run(page):
    """The commands of a page and what became of them; where there is no bus, without those that need one."""
    command = [sys.executable, "-B", str(HERE / "typed_page.py"), page]
    with_can = [str(program.REPOSITORY / "toolchain/with-can")] if commands.speaks_can(page) else []
    for before in ([with_can] if with_can else []) + [[]]:
        done = subprocess.run([*before, *command], capture_output=True, text=True, timeout=580)
        if before and done.returncode == SKIPPED:
            print(done.stdout.strip())
            continue
        break
    _, mark, result = done.stdout.partition("@@ result ")
    if not mark:
        raise RuntimeError(f"{page}: {done.stdout}\n{done.stderr}")
    return json.loads(result)


def selects_a_test(command, names):
    """Whether the pattern of a `ctest -R` finds a test, or may find one of a program that is not built."""
    words = shlex.split(command)
    pattern = words[words.index("-R") + 1] if "-R" in words else "."
    return any(re.search(pattern, name) or name.endswith("_NOT_BUILT") for name in names)


def check_page(page):
    typed = run(page)
    names = tests_of_ctest() if any(one["kind"] == "ctest" for one in typed) else []
    for one in typed:
        if one["kind"] == "ctest" and one["outcome"] == "ok" and not selects_a_test(one["text"], names):
            one.update(outcome="failed", why="selects no test")
        first, *_ = one["text"].splitlines()
        print(f"{one['outcome']:9} {one['seconds']:6.1f} s  {page}:{one['line']}: {first}")
        if one["why"]:
            print("            " + one["why"].strip().replace("\n", "\n            "))
    failed = [one for one in typed if one["outcome"] == "failed"]
    done = [one for one in typed if one["outcome"] == "ok"]
    print(f"{len(done)} done, {len(failed)} failed, {len(typed) - len(done) - len(failed)} neither")
    if failed:
        return 1
    reasons = [one["why"] for one in typed if one["outcome"] == "skipped"]
    if not done and reasons:
        print(f"SKIP: {reasons[0]}")
        return SKIPPED
    return 0


def check_list():
    """Each entry of the tables is of use; commands of slipstack that are not typed are at least ones that it takes."""
    wrong, covered, names = [], {}, tests_of_ctest()
    for page in pages():
        asked, rest = commands.commands(page)
        for command in asked:
            entry = commands.not_typed(command)
            if entry:
                covered.setdefault(entry, []).append(f"{page}:{command.line}: {command.text}")
                wrong += refused(command)
        begins = [shown.begins for shown in fixtures.SHOWN.get(page, ())]
        used = {next((begin for begin in begins if block.text.startswith(begin)), None) for block in rest}
        wrong += [f"{page}: no block begins with {begin!r}" for begin in begins if begin not in used]
    for entry in fixtures.NOT_TYPED:
        print(f"not typed: {entry.reason}" + (f" ({entry.test})" if entry.test else ""))
        for place in covered.get(entry, ()):
            print(f"    {place}")
        if entry not in covered:
            wrong.append(f"no page has a command {entry.command}")
    named = {entry.test for entry in fixtures.NOT_TYPED} | set(fixtures.PAGES_OF_OTHER_TESTS.values()) | {
        shown.test for entries in fixtures.SHOWN.values() for shown in entries}
    wrong += [f"CTest has no {name}" for name in sorted(named - {None, ""})
              if not any(re.search(name, one) or one.endswith("_NOT_BUILT") for one in names)]
    everything = "\n".join((program.REPOSITORY / page).read_text() for page in pages())
    wrong += [f"no page names {name}" for name in fixtures.FILES
              if name not in everything and not any(name in shown.names for entries in fixtures.SHOWN.values() for shown in entries)
              and name != "logs/monday.csv"]
    wrong += [f"{page}: no command is {pattern}" for page, pattern, _ in fixtures.PRINTED
              if not any(re.fullmatch(pattern, command.text) for command in commands.commands(page)[0])]
    if len(fixtures.NOT_TYPED) > MOST_NOT_TYPED:
        wrong.append(f"{len(fixtures.NOT_TYPED)} entries, more than {MOST_NOT_TYPED}")
    for line in wrong:
        print(f"FAIL: {line}")
    return 1 if wrong else 0


def refused(command):
    """What slipstack says of a command that is not typed, beside an option that there is not: nothing else."""
    words = shlex.split(command.text, comments=True)
    if words[0] != "slipstack" or command.kind != "typed":
        return []
    done = subprocess.run([program.SLIPSTACK, *words[1:], "--no-such-option"], capture_output=True, text=True, timeout=program.PATIENCE_S)
    return [] if "not expected: --no-such-option;" in done.stderr else [f"{command.text}: {done.stderr}"]


def main():
    word, *others = sys.argv[1:]
    if word == "--pages":
        for page in pages():
            print(("can " if commands.speaks_can(page) else "") + page)
        return 0
    if word == "--listed":
        return check_list()
    statuses = {check_page(page) for page in [word, *others]}
    return 1 if 1 in statuses else max(statuses) if statuses == {SKIPPED} else 0


if __name__ == "__main__":
    sys.exit(main())
