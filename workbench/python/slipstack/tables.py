# SPDX-License-Identifier: Apache-2.0
"""What the converters of this package have in common: the table for `slipstack import`, and their one line on a fault."""

import csv
import sys


class BadInput(Exception):
    """What is wrong with the input, in one line."""


def converted(program, out, read, decimals):
    """Status of a converter: writes what read() returns, a head and rows that begin with a time [s], as CSV to a file or, as
    '-', to standard output. 2 and one line where read() raises BadInput or a file cannot be used."""
    try:
        head, rows = read()
        target = sys.stdout if out == "-" else open(out, "w", newline="", encoding="utf-8")
        with target:
            writer = csv.writer(target, lineterminator="\n")
            writer.writerow(head)
            writer.writerows([f"{row[0]:.{decimals}f}", *row[1:]] for row in rows)
    except (BadInput, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2
    return 0
