# SPDX-License-Identifier: Apache-2.0
"""Logs of a generator, diagnosed and judged: what stranger_generator.py and joint_generator.py share."""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]


def number(values, name):
    """A value in N, or in N m of a rotary axis."""
    return next(value for key, value in values.items() if key.startswith(name))


class Generator:
    """Cases, and what a right answer to them is.

    `cases`: tuples of hidden names, by seed; `singles`: names that a right answer may name first; `outside`: coordinates
    of what is unexplained. make_log(seed, hidden, path) writes a log and returns what is noted of it; label(note) is its
    columns, counted(note) whether an effect in it is large enough to count.
    """

    def __init__(self, prefix, cases, singles, outside, make_log, label, counted=lambda note: True, width=26, options=()):
        self.prefix, self.cases, self.singles, self.outside = prefix, cases, singles, outside
        self.make_log, self.label, self.counted, self.width, self.options = make_log, label, counted, width, options

    def verdict_of(self, hidden, found):
        """Group, whether right, and what kind of mistake."""
        ranked = [one["effect"] for one in found["candidates"][:2]]
        verdict = found["verdict"]
        named = verdict == "missing_effect"
        if not hidden:
            return "clean", not named, "false alarm" if named else ""
        if hidden[0] in self.outside:
            where = (found.get("unexplained") or {}).get("coordinate", "")
            ok = verdict == "unexplained" and where in self.outside[hidden[0]]
            kind = "" if ok else "wrong name" if named else "wrongly complete" if verdict == "complete" else f"at {where}"
            return "outside", ok, kind
        right = set().union(*(self.singles[name] for name in hidden))
        group = "single" if len(hidden) == 1 else "pair"
        if named:
            first = ranked[0] in right
            return group, first, "" if first else "second" if ranked[1] in right else "wrong name"
        return group, False, "unexplained" if verdict == "unexplained" else "wrongly complete"

    def judged(self, wanted, seed, hidden, folder):
        """Makes one log, diagnoses it, prints its line: group, right, mistake, counted."""
        path, note_path = folder / f"{self.prefix}_{seed}.csv", folder / f"{self.prefix}_{seed}.json"
        if not note_path.exists():
            note_path.write_text(json.dumps(self.make_log(seed, hidden, path)))
        note = json.loads(note_path.read_text())
        began = time.monotonic()
        done = subprocess.run([wanted.slipstack, "diagnose", str(path), *self.options, "--json", "-"], capture_output=True, text=True, check=False)
        seconds = time.monotonic() - began
        if not wanted.keep:
            path.unlink()
            note_path.unlink()
        label = f"{seed:4d} {'+'.join(hidden) or '-':{self.width}.{self.width}}{self.label(note)}{seconds:6.1f}  "
        if done.returncode != 0:
            print(f"{label}status {done.returncode}: {done.stderr.strip()}   <-- refused", flush=True)
            return "refused", False, "", True
        found = json.loads(done.stdout)
        group, right, mistake = self.verdict_of(hidden, found)
        steps = found.get("steps", [])
        named = [one["effect"] for one in steps[1:] or found["candidates"][:2]]
        told = ", ".join(named) if found["verdict"] == "missing_effect" else (found.get("unexplained") or {}).get("coordinate", "")
        floor = number(found, "noise_floor_N")
        over = number(steps[-1] if steps else found["candidates"][0], "holdout_rmse_N") / floor
        base = number(found["baseline"], "holdout_rmse_N") / floor
        print(f"{label}{found['verdict'][:11]:12}{base:6.2f}>{over:5.2f} {told}{'' if right else '   <-- ' + mistake}", flush=True)
        return group, right, mistake, group in ("clean", "outside") or self.counted(note)

    def main(self, title):
        """Status 1 when anything is named on a log without a hidden effect."""
        parser = argparse.ArgumentParser(description=title)
        parser.add_argument("--slipstack", default=str(ROOT / "build/host/bin/slipstack"))
        parser.add_argument("--logs", type=int, default=len(self.cases))
        parser.add_argument("--first-seed", type=int, default=1)
        parser.add_argument("--keep", help="folder for the logs, which are made once; by default they are thrown away")
        parser.add_argument("--only", default="", help="cases whose name contains this; clean for those without any")
        wanted = parser.parse_args()
        counts = {}
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(wanted.keep or scratch)
            folder.mkdir(parents=True, exist_ok=True)
            for seed in range(wanted.first_seed, wanted.first_seed + wanted.logs):
                hidden = self.cases[seed % len(self.cases)]
                if wanted.only not in ("+".join(hidden) or "clean"):
                    continue
                group, right, mistake, counted = self.judged(wanted, seed, hidden, folder)
                if counted:
                    counts.setdefault(group, []).append((right, mistake))
        print()
        for group in ("single", "pair", "clean", "outside", "refused"):
            if group in counts:
                mistakes = [m for right, m in counts[group] if not right]
                tally = ", ".join(f"{mistakes.count(m)} {m}" for m in sorted(set(mistakes)))
                print(f"{group:9}{sum(right for right, _ in counts[group]):3d} of {len(counts[group]):3d} right{'; ' + tally if tally else ''}")
        return 1 if any(not right for right, _ in counts.get("clean", [])) else 0
