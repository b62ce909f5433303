# SPDX-License-Identifier: Apache-2.0
"""Committed budgets: CSV with comments at its head, which an update keeps."""

import csv
import pathlib


def read(path):
    """(comments, rows); both empty where there is no file yet."""
    path = pathlib.Path(path)
    lines = path.read_text().splitlines() if path.is_file() else []
    comments = [line for line in lines if line.startswith("#")]
    return comments, list(csv.DictReader(line for line in lines if not line.startswith("#")))


def write(path, comments, columns, rows):
    with open(path, "w", newline="") as file:
        file.writelines(f"{comment}\n" for comment in comments)
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
