# SPDX-License-Identifier: Apache-2.0
"""Types the commands of one page, in their order, compares what the page shows, and prints as JSON what became of each.
typed_page_test.py starts it, where there is a CAN bus if the page speaks to one.

    typed_page.py PAGE
"""

import dataclasses
import json
import pathlib
import re
import sys

import fixtures
from commands import Command, commands
from session import Session
from shown import compare, not_printed


def main():
    page, = sys.argv[1:]
    with Session(page, pathlib.Path("/sys/class/net/vcan0").exists()) as session:
        found, rest = commands(page)
        for number, command in enumerate(found):
            same = next((one for one in found[:number] if one.text == command.text), None)
            if command.inline and same:  # a sentence about a line that was typed
                command.outcome, command.why = same.outcome, f"as line {same.line}"
                continue
            session.type(command)
            for of, pattern, expected in fixtures.PRINTED:
                if of == page and command.outcome == "ok" and re.fullmatch(pattern, command.text) and not re.search(expected, command.output, re.MULTILINE):
                    session.fail(command, f"does not print {expected}, but\n{command.output[:3000]}")
            if command.outcome == "ok" and command.shown:
                wrong = not_printed(command.shown, command.output, fixtures.TOLERANCES.get(page, 0.0))
                if wrong:
                    session.fail(command, "does not print\n" + "\n".join(wrong) + "\nbut\n" + command.output[:3000])
        for block in rest:
            shown = Command(block.line, block.text.splitlines()[0], "shown")
            found.append(shown)
            try:
                wrong = compare(session, block, found)
                if wrong:
                    session.fail(shown, wrong)
            except fixtures.Absent as reason:
                shown.outcome, shown.why = "skipped", str(reason)
        check = fixtures.AFTERWARDS.get(page)
        missing = [name for name in check or () if not list(session.here.glob(name))]
        if missing:
            found.append(Command(0, "files that the page speaks of", outcome="failed", why=f"not there: {missing}"))
        print("@@ result " + json.dumps([dataclasses.asdict(one) for one in found]))


if __name__ == "__main__":
    main()
