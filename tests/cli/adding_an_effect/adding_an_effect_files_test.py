# SPDX-License-Identifier: Apache-2.0
"""The files for CAN of a catalogue with one more effect: it comes last, and everything else keeps its object.

    python3 adding_an_effect_files_test.py PROGRAM DOCS      canopen-files with that catalogue; the real documents
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

program, docs = sys.argv[1], pathlib.Path(sys.argv[2])
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    shutil.copy(docs / "effect-objects.csv", folder)
    subprocess.run([program, folder], check=True)
    before, after = ((place / "effect-objects.csv").read_text().splitlines() for place in (docs, folder))
    assert after[:-1] == before and after[-1].endswith(",eddy_current_brake"), after[-1]
    index = after[-1].split(",")[0]
    assert int(index[:4], 16) == int(before[-1][:4], 16) + 1, index

    def objects(place):
        rows = (place / "object-dictionary.md").read_text().splitlines()
        return {row.split(" | ")[0]: row for row in rows if "h" in row.split(" | ")[0]}

    old, new = objects(docs), objects(folder)
    added = [row for key, row in new.items() if key not in old]
    assert any(row.startswith(f"| {index}:02 | peak_force | REAL32") for row in added), added
    assert any(row.startswith("| 2201h:") and "Eddy-current brake" in row for row in added), added
    # Only how many rows 2201h has is another number.
    changed = [key for key, row in old.items() if new[key] != row]
    assert changed == ["| 2201h:00"], changed
