#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""EMPS, a real axis: its parameters beside the published ones, and the effect that the published model lacks.

    python3 docs/python/emps.py emps_estimation.csv

Published values: Janot, Gautier, Brunot 2019.
"""

import sys

import pandas
import slipstack

PUBLISHED = {"inertia": 95.11, "viscous": 203.5, "coulomb": 20.39, "offset_force": -3.16}

frame = pandas.read_csv(sys.argv[1], comment="#", float_precision="round_trip")
fitted = slipstack.fit(frame, list(PUBLISHED))
for effect in fitted.parameters:
    gain = effect.parameters[-1]  # shapes stand before it
    print(f"{effect.effect:14} {gain.value:8.3f} {gain.unit:6} +- {gain.standard_error:.3f}, "
          f"published {PUBLISHED[effect.effect]}")
print(f"error: {100 * fitted.relative_error:.2f} % of the force")

found = slipstack.diagnose(frame, model=fitted)
best = found.candidates[0]
print(f"missing: {best.effect}: {best.evidence}")

better = slipstack.add(frame, fitted, best.effect)
print(f"error with it: {100 * better.relative_error:.2f} % of the force")
