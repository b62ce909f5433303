#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A log in which an effect may be hidden: names it, adds it to the baseline, shows what that gains.

    python3 docs/python/hidden_effect.py log.csv

Writes better.toml and better.html.
"""

import sys

import slipstack

log = sys.argv[1]


def show(stage, fraction):
    share = "" if fraction is None else f"{100 * fraction:3.0f} %"
    print(f"\r{stage:40} {share:5}", end="", file=sys.stderr)


found = slipstack.diagnose(log, stepwise=True, progress=show)
print(file=sys.stderr)
if found.verdict != "missing_effect":
    print(found.verdict, found.unexplained or "")
    raise SystemExit

best = found.candidates[0]
print(f"{best.effect}: {best.evidence}")
baseline = slipstack.fit(log, found.baseline_effects)
better = slipstack.add(log, baseline, best.effect, out="better.toml", report="better.html")
print(f"held-out error {baseline.holdout_rmse_N:.4f} N, with it {better.holdout_rmse_N:.4f} N; "
      f"noise floor {better.noise_floor_N:.4f} N")
