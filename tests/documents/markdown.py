# SPDX-License-Identifier: Apache-2.0
"""The blocks and the words in code type of the pages: the one reader of Markdown of the tests."""

import dataclasses
import pathlib
import re

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
NOT_PAGES = ("build", "out", "node_modules", "tests")
FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


@dataclasses.dataclass
class Code:
    """A fenced block, or a span in code type within a line (`inline`)."""
    line: int
    language: str
    text: str
    inline: bool = False


def pages():
    """Every page of the project, by its path from the root; of the change log no command is asked for again."""
    found = (path.relative_to(REPOSITORY) for path in REPOSITORY.rglob("*.md"))
    return sorted(str(path) for path in found
                  if path.name != "CHANGELOG.md" and not any(part in NOT_PAGES or part.startswith(".") for part in path.parts))


def code(page):
    """Blocks and spans of a page, in their order."""
    text = (REPOSITORY / page).read_text()
    found = [Code(text.count("\n", 0, match.start()) + 1, match[1], match[2]) for match in FENCED.finditer(text)]
    # The blocks leave their lines, so that a span has its number too. A span does not cross a line.
    without = FENCED.sub(lambda match: "\n" * match[0].count("\n"), text)
    for number, line in enumerate(without.split("\n"), 1):
        found += [Code(number, "", span.replace("\\|", "|"), True) for span in re.findall(r"`([^`]+)`", line)]
    return sorted(found, key=lambda one: one.line)


def blocks(page, language=None):
    """The fenced blocks of a page of docs, in their order; those of one language only."""
    return [one for one in code(f"docs/{page}") if not one.inline and language in (None, one.language)]
