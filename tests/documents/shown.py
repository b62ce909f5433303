# SPDX-License-Identifier: Apache-2.0
"""Whether what a page shows is what the programs print and write."""

import re

import fixtures
from fixtures import program


def normal(line):
    return re.sub(r" +", " ", line).strip()


NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


def alike(shown, printed, tolerance):
    """Whether two lines are the same but for numbers that differ by less than this share."""
    if tolerance == 0.0 or NUMBER.split(shown) != NUMBER.split(printed):
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)))
    return all(abs(a - b) <= tolerance * max(abs(a), abs(b)) for a, b in pairs)


def not_printed(shown, output, tolerance=0.0):
    """The lines that a page shows and no line of the output is, or holds; blanks do not count, dots stand for lines left out."""
    lines = [normal(line) for line in output.splitlines()]
    return [line for line in map(normal, shown) if line and line != "..."
            and not any(line in one or alike(line, one, tolerance) for one in lines)]


def as_log(session, block):
    """The beginning of a log that a page shows, before rows that go on with it, is a log that is read."""
    program.small_log(session.here / "rows.csv", "viscous")
    lines = (session.here / "rows.csv").read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("time_s"))
    head = [line for line in block.text.splitlines() if not line[:1].isdigit()]
    if head[-1] != lines[first]:
        return f"the rows of a log are {lines[first]}"
    (session.here / "shown.csv").write_text("\n".join(head + lines[first + 1:]) + "\n")
    done = session.shell("slipstack fit shown.csv --effects inertia,presliding_hysteresis,viscous --model shown.toml")
    return "" if done.returncode == 0 and not done.stderr else done.stderr


def as_excerpt(session, block, name):
    """Every table and every name of an excerpt is in a whole file."""
    session.provide(name)
    whole = (session.here / name).read_text()
    names = re.findall(r"^ *(\[\[?[\w.]+\]\]?|\w+ =)", block.text, re.MULTILINE)
    return ", ".join(one for one in names if not re.search(rf"^ *{re.escape(one)}", whole, re.MULTILINE))


def as_named(block, folder):
    """The names of a list of files that no source of a folder has in a text of its own."""
    text = "".join(path.read_text() for path in (program.REPOSITORY / folder).rglob("*.cpp"))
    names = [line.split()[0].split("/")[0] for line in block.text.splitlines()]
    return ", ".join(name for name in names if not re.search(rf'"{re.escape(name)}["/]', text))


def compare(session, block, found):
    """What is wrong with a block that is no command."""
    entry = next((one for one in fixtures.SHOWN.get(session.page, ()) if block.text.startswith(one.begins)), None)
    if entry is None:
        return "no command, and fixtures.SHOWN does not say what it is compared with"
    lines = block.text.splitlines()
    if entry.log:
        return as_log(session, block)
    if entry.file:
        return as_excerpt(session, block, entry.file)
    if entry.source:
        return as_named(block, entry.source)
    if entry.of:
        command = next((one for one in found if one.text == entry.of), None)
        return f"{entry.of} is not on the page" if command is None else "\n".join(not_printed(lines, command.output)) if command.outcome == "ok" else ""
    if entry.command:
        text = entry.command.format(second=lines[1].strip() if len(lines) > 1 else "")
        session.provide(f"{text} {entry.names}")
        done = session.shell(text)
        return "\n".join(not_printed(lines, done.stdout + done.stderr))
    return ""
