# SPDX-License-Identifier: Apache-2.0
"""What a page asks to type: its commands, each with the output that the page prints under it."""

import dataclasses
import functools
import re

import fixtures
import markdown

# Words that a command begins with, after variables that are set for it.
PROGRAM = re.compile(r"(?:\w+=\S+ )*(?:chrt -r \d+ )?(slipstack|slipstack-sim|python3|cmake|ctest|mpirun|octave|candump|cansend|slcand|"
                     r"podman|buildah|debootstrap|tar|apt|touch|libreoffice|export|qemu-system-arm|\.|"
                     r"build/host/bin/\S+|toolchain/\S+|\.ci/run|tests/\S+\.py|\w+_test)( |$)")


@dataclasses.dataclass
class Command:
    line: int
    text: str               # as printed
    kind: str = "typed"     # typed, mentioned, ctest, test_program, script, python, matlab, c, cmake
    shown: list = dataclasses.field(default_factory=list)  # output that the page prints under it
    outcome: str = "ok"     # ok, failed, skipped, not typed
    why: str = ""
    output: str = ""
    seconds: float = 0.0
    inline: bool = False


def kind_of(text, inline):
    """What is done with a command; None: no command, a name in code type."""
    match = PROGRAM.match(text)
    if match is None or inline and " " not in text:
        return None
    name = match[1]
    if inline and name == "qemu-system-arm":  # a machine is named
        return None
    if name == "ctest":
        return "ctest"
    if name.startswith("tests/"):
        return "script"
    if name.endswith("_test"):
        return "test_program"
    # In a sentence a command is named without what it works on.
    if inline and name == "slipstack" and re.fullmatch(r"slipstack( [a-z-]+| --[a-z-]+)+( [a-z][a-z-]*,)*", text) and not re.search("--help", text):
        return "mentioned"
    if inline and re.fullmatch(r"python3 -m [\w.]+|(podman|buildah) \w+|mpirun --quiet", text):
        return "mentioned"
    return "typed"


def lines_of(text):
    """(offset, line) of a block, a line that goes on behind a backslash being one."""
    offset, line = 0, ""
    for number, one in enumerate(text.splitlines()):
        if line == "":
            offset = number
        line += one
        if line.endswith("\\"):
            line = line[:-1]
            continue
        yield offset, line
        line = ""


def without_comment(line):
    """A line of a shell without its comment."""
    return re.sub(r"(^|\s+)#\s.*$", "", line).strip()


@functools.cache
def commands(page):
    """(what the page asks to type, blocks that are no commands)."""
    found, rest = [], []
    for code in markdown.code(page):
        if code.inline:
            kind = kind_of(code.text, True)
            if kind:
                found.append(Command(code.line, code.text, kind, inline=True))
            continue
        lines = list(lines_of(code.text))
        if code.language in ("python", "matlab", "c", "cmake"):
            found.append(Command(code.line, code.text, code.language))
        elif code.language in ("", "sh") and any(line.startswith("$ ") for _, line in lines):
            for offset, line in lines:
                if line.startswith("$ "):
                    found.append(Command(code.line + 1 + offset, without_comment(line[2:])))
                else:
                    found[-1].shown.append(line)
        elif code.language in ("", "sh") and kind_of(next((without_comment(line) for _, line in lines if without_comment(line)), ""), False):
            for offset, line in lines:
                if without_comment(line):
                    found.append(Command(code.line + 1 + offset, without_comment(line), kind_of(without_comment(line), False) or "typed"))
        elif code.language == "text":
            found[-1].shown += code.text.splitlines()
        else:
            rest.append(code)
    return found, rest


def speaks_can(page):
    """Whether what is typed of the page needs a bus."""
    found, _ = commands(page)
    return page not in fixtures.PAGES_OF_OTHER_TESTS and any(
        command.kind == "typed" and not not_typed(command) and re.search(r"can0|^cansend", command.text) for command in found)


def not_typed(command):
    return next((entry for entry in fixtures.NOT_TYPED if entry.covers(command.text)), None) if command.kind in ("typed", "mentioned") else None


def files_written(words):
    """Files that a command line says it writes."""
    takes = ["--out", "--report", "--json", "--write-log", "--save-profile", "--keep", "--c", ">"]
    if "fit" in words[:2]:
        takes.append("--model")
    if "effects" in words[:2]:
        takes += ["--header", "--pages"]
    return [after for word, after in zip(words, words[1:]) if word in takes and after != "-"]
