#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hidden effects in logs that sim_host did not make: another generator, with formulas and motions of its own.

    tests/bench/blind/other_generator.py [--slipstack PROGRAM] [--logs N] [--first-seed S] [--keep FOLDER]

The motion is prescribed (quintic moves, constant speeds, a multisine, a swept sine) and the force computed from it:
inertia, stop operators under a virgin curve that the program does not have (tanh, logarithm, two exponentials), white
noise, encoder steps, and one hidden effect, two of them, none, or something outside the catalogue. The effects have
formulas that differ from the catalogue's wherever that leaves them what they are called: Stribeck friction by a
rational curve, grease by a power, drift by the root of time, a preload by sines, an asymmetry by tanh of the velocity.

Prints a line for each log, then counts. Needs python3-numpy. Status 1 when a single effect that raises the error by
10 % over the noise is not named first, or anything is named on a log without a hidden effect.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[3]
SINGLES = ["viscous", "quadratic_drag", "stribeck", "offset_force", "direction_asymmetry", "force_ripple",
           "position_dependent_preload", "cable_chain_stiffness", "payload_mass", "drift",
           "acceleration_dependent_preload", "structural_resonance", "time_delay", "motor_constant_ripple"]
PAIRS = [("viscous", "force_ripple"), ("payload_mass", "direction_asymmetry"), ("drift", "cable_chain_stiffness")]
OUTSIDE = ["line", "level_step", "bump", "random_walk"]
FINE_HZ = 32000  # of the motion before it is sampled: its derivatives are those of the motion
CASES = [()] + [(name,) for name in SINGLES] + PAIRS + [(name,) for name in OUTSIDE]


def smooth(u):
    """From 0 to 1 with velocity and acceleration zero at both ends."""
    u = numpy.clip(u, 0.0, 1.0)
    return u ** 3 * (10 - 15 * u + 6 * u * u)


class Motion:
    """Segments of motion that follow one another; the axis stands between them."""

    def __init__(self, rng, step_s, stroke_m):
        self.rng, self.step_s, self.stroke_m = rng, step_s, stroke_m
        self.at_m, self.pieces = 0.5 * stroke_m, []

    def add(self, x_m):
        self.pieces.append(x_m)
        self.at_m = float(x_m[-1])

    def move(self, to_m, acceleration_mps2, rest_s):
        seconds = max((5.8 * abs(to_m - self.at_m) / acceleration_mps2) ** 0.5, 0.05)
        time_s = numpy.arange(0.0, seconds + rest_s, self.step_s)
        self.add(self.at_m + (to_m - self.at_m) * smooth(time_s / seconds))

    def stroke(self, to_m, speed_mps):
        """Constant speed but for a tenth of the way at both ends."""
        way_m = abs(to_m - self.at_m)
        seconds = way_m / (0.9 * speed_mps)
        u = numpy.arange(0.0, 1.0, self.step_s / seconds)
        rate = smooth(u / 0.1) * smooth((1.0 - u) / 0.1)
        way = numpy.cumsum(rate)
        self.add(self.at_m + (to_m - self.at_m) * way / way[-1])

    def waves(self, seconds, wave):
        """wave(t), faded in and out over a tenth of the time."""
        time_s = numpy.arange(0.0, seconds, self.step_s)
        fade = smooth(time_s / (0.1 * seconds)) * smooth((seconds - time_s) / (0.1 * seconds))
        self.add(self.at_m + fade * wave(time_s))

    def moves(self):
        for _ in range(25):
            self.move(self.rng.uniform(0.05, 0.95) * self.stroke_m, self.rng.uniform(1.0, 8.0), self.rng.uniform(0.02, 0.2))
        self.move(0.5 * self.stroke_m, 2.0, 0.1)
        for amplitude_m in (3e-6, 10e-6, 40e-6, 200e-6):
            self.waves(3.0, lambda t, a=amplitude_m: a * numpy.sin(2 * numpy.pi * t))
        for speed_mps in (0.7e-3, 5e-3, 30e-3):
            way_m = min(0.1 * self.stroke_m, 2.0 * speed_mps)
            for sign in (1, -1):
                self.stroke(self.at_m + sign * way_m, speed_mps)

    def speeds(self):
        for speed_mps in numpy.geomspace(2e-3, 0.3, 9):
            way_m = min(0.4 * self.stroke_m, 3.0 * speed_mps)
            middle_m = self.at_m
            self.move(middle_m - 0.5 * way_m, 2.0, 0.05)
            for sign in (1, -1, 1, -1):
                self.stroke(self.at_m + sign * way_m, speed_mps)
            self.move(middle_m, 2.0, 0.05)

    def multisine(self):
        tones = [(f, self.rng.uniform(0, 2 * numpy.pi)) for f in numpy.geomspace(0.07, 6.0, 14)]
        largest = sum(f ** -1.2 for f, _ in tones)
        self.waves(40.0, lambda t: 0.45 * self.stroke_m / largest *
                   sum(numpy.sin(2 * numpy.pi * f * t + p) * f ** -1.2 for f, p in tones))

    def sweep(self):
        for share, first_Hz, last_Hz in ((0.3, 0.1, 1.0), (0.01, 0.3, 8.0)):
            self.waves(30.0, lambda t, s=share, f0=first_Hz, f1=last_Hz: s * self.stroke_m *
                       numpy.sin(2 * numpy.pi * (f0 * t + (f1 - f0) * t * t / 60.0)))


def stop_operators(x_m, level_N, length_m, kind):
    """Force of sixty elements under the virgin curve."""
    slip_m = numpy.geomspace(0.02 * length_m, 6.0 * length_m, 60)
    force_N = {"tanh": lambda u: numpy.tanh(u), "log": lambda u: numpy.minimum(1.0, numpy.log1p(u) / numpy.log1p(6.0)),
               "two": lambda u: 1.0 - 0.6 * numpy.exp(-u) - 0.4 * numpy.exp(-4.0 * u)}[kind](slip_m / length_m) * level_N
    slope = numpy.diff(force_N, prepend=0.0) / numpy.diff(slip_m, prepend=0.0)
    stiffness = numpy.maximum(slope - numpy.append(slope[1:], 0.0), 0.0)
    deflection, out = numpy.zeros(60), numpy.empty(len(x_m))
    for i, step_m in enumerate(numpy.diff(x_m, prepend=x_m[0])):
        deflection = numpy.clip(deflection + step_m, -slip_m, slip_m)
        out[i] = stiffness @ deflection
    return out


def resonance_force(acceleration_mps2, step_s, mass_kg, frequency_Hz, share):
    """What an arm of `share` of the mass on a spring adds, by semi-implicit Euler steps."""
    w, q, rate, out = 2 * numpy.pi * frequency_Hz, 0.0, 0.0, numpy.empty(len(acceleration_mps2))
    for i, a in enumerate(acceleration_mps2):
        swing = -a - w * w * q - 0.04 * w * rate
        rate += swing * step_s
        q += rate * step_s
        out[i] = share * mass_kg * swing
    return out


def make_log(seed, hidden, path):
    """Writes a log; returns the name of its motion and how far the hidden part raises the error over the noise."""
    rng = numpy.random.default_rng(seed)
    rate_Hz = int(rng.choice([1000, 2000, 4000]))
    stroke_m = rng.uniform(0.1, 0.8)
    motion = Motion(rng, 1.0 / FINE_HZ, stroke_m)
    kind = rng.choice(["moves", "speeds", "multisine", "sweep"])
    getattr(motion, kind)()
    x = numpy.concatenate(motion.pieces)
    v = numpy.gradient(x, 1.0 / FINE_HZ)
    a = numpy.gradient(v, 1.0 / FINE_HZ)
    x, v, a = (fine[::FINE_HZ // rate_Hz] for fine in (x, v, a))
    t = numpy.arange(len(x)) / rate_Hz
    mass_kg, level_N = rng.uniform(2, 50), rng.uniform(2, 25)
    hysteresis_N = stop_operators(x, level_N, 10 ** rng.uniform(-5.7, -4.3), rng.choice(["tanh", "log", "two"]))
    bare_N = mass_kg * a + hysteresis_N
    size_N, noise_N = level_N * rng.uniform(0.08, 0.3), level_N * rng.uniform(0.003, 0.02)
    top_mps = numpy.abs(v).max()
    side = v / numpy.hypot(v, 1e-6)
    factor, added_N, delay_s, gain = 1.0, 0.0, 0.0, 1.0
    for name in hidden:
        if name == "viscous":
            added_N += size_N * numpy.sign(v) * (2 * numpy.abs(v) / top_mps) ** rng.uniform(0.85, 1.0)
        elif name == "quadratic_drag":
            added_N += 2 * size_N * v * numpy.abs(v) / top_mps ** 2
        elif name == "stribeck":
            factor *= 1 - rng.uniform(0.2, 0.4) * numpy.abs(v) / (numpy.abs(v) + 0.02 * top_mps)
        elif name == "offset_force":
            added_N += size_N
        elif name == "direction_asymmetry":
            factor *= 1 + rng.uniform(0.08, 0.2) * numpy.tanh(v / 1e-4)
        elif name == "force_ripple":
            angle = 2 * numpy.pi * x / rng.choice([0.012, 0.02, 0.032])
            added_N += size_N * (numpy.sin(angle + 1) + 0.3 * numpy.sin(3 * angle + 2))
        elif name == "position_dependent_preload":
            factor *= 1 + rng.uniform(0.1, 0.2) * sum(
                numpy.sin(2 * numpy.pi * k * x / stroke_m + rng.uniform(0, 6)) / k for k in (0.7, 1.6, 2.9))
        elif name == "cable_chain_stiffness":
            u = x / stroke_m - rng.uniform(0.3, 0.7)
            added_N += 3 * size_N * (u + 0.15 * u ** 3)
        elif name == "payload_mass":
            added_N += rng.uniform(0.08, 0.2) * mass_kg * a
        elif name == "drift":
            factor *= 1 - rng.uniform(0.2, 0.4) * numpy.sqrt(t / t[-1])
        elif name == "acceleration_dependent_preload":
            factor *= 1 + 0.3 * numpy.abs(a) / numpy.abs(a).max()
        elif name == "structural_resonance":
            added_N += resonance_force(a, 1.0 / rate_Hz, mass_kg, rng.uniform(25, 60), rng.uniform(0.15, 0.4))
        elif name == "time_delay":
            delay_s = rng.uniform(1.5, 4.0) / rate_Hz
        elif name == "motor_constant_ripple":
            gain = 1 + 0.06 * numpy.sin(2 * numpy.pi * x / 0.024 + 0.5)
        elif name == "line":
            added_N += size_N * numpy.sin(2 * numpy.pi * 50.0 * t)
        elif name == "level_step":
            factor *= numpy.where(t > 0.55 * t[-1], 1.25, 1.0)
        elif name == "bump":
            added_N += 3 * size_N * side * numpy.exp(-((x - 0.5 * stroke_m) / 4e-3) ** 2)
        elif name == "random_walk":
            added_N += 0.04 * size_N * numpy.cumsum(rng.normal(size=len(x))) / rate_Hz ** 0.5
    force_N = mass_kg * a + hysteresis_N * factor + added_N
    force_N = numpy.interp(t - delay_s, t, force_N) / gain
    raised = float(numpy.hypot(1.0, numpy.sqrt(numpy.mean((force_N - bare_N) ** 2)) / noise_N))
    step_m = rng.choice([1e-8, 1e-7, 5e-7])
    head = {"mass_kg": mass_kg, "encoder_resolution_m": step_m}
    if rng.random() < 0.7:
        head["magnet_pitch_m"] = 0.024
    with open(path, "w") as log:
        log.writelines(f"# {key}: {value}\n" for key, value in head.items())
        log.write("time_s,position_m,force_N\n")
        columns = numpy.c_[t, numpy.round(x / step_m) * step_m, force_N + noise_N * rng.normal(size=len(x))]
        numpy.savetxt(log, columns, fmt=["%.6f", "%.9f", "%.5f"], delimiter=",")
    return kind, raised


def diagnose(program, path):
    done = subprocess.run([program, "diagnose", str(path), "--json", "-"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{path}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slipstack", default=str(ROOT / "build/host/bin/slipstack"))
    parser.add_argument("--logs", type=int, default=2 * len(CASES))
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--keep", help="folder for the logs; by default they are thrown away")
    wanted = parser.parse_args()
    counts = {"single": [0, 0], "pair": [0, 0], "nothing": [0, 0], "outside": [0, 0]}
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(wanted.keep or scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print(f"{'seed':>5}  {'motion':10}{'hidden':36}{'raised':>8}  {'verdict':16}named")
        for seed in range(wanted.first_seed, wanted.first_seed + wanted.logs):
            hidden = CASES[seed % len(CASES)]
            path = folder / f"other_{seed}.csv"
            motion, raised = make_log(seed, hidden, path)
            found = diagnose(wanted.slipstack, path)
            if not wanted.keep:
                path.unlink()
            verdict = found["verdict"]
            ranked = [one["effect"] for one in found["candidates"][:3]]
            named = verdict == "missing_effect"
            if not hidden:
                group, right = "nothing", not named
            elif hidden[0] in OUTSIDE:
                # A level that changes at one moment is drift of a form that the catalogue does not have.
                group, right = "outside", not named or (hidden[0] == "level_step" and ranked[0] == "drift")
            elif len(hidden) == 2:
                group, right = "pair", named and ranked[0] in hidden
            else:
                group, right = "single", named and ranked[0] == hidden[0]
            if raised >= 1.1 or not hidden:
                counts[group][0] += right
                counts[group][1] += 1
            print(f"{seed:5d}  {motion:10}{' + '.join(hidden) or '-':36}{raised:8.2f}  {verdict:16}{', '.join(ranked)}"
                  f"{'' if right else '   <--'}", flush=True)
    print()
    for group, text in (("single", "named first"), ("pair", "one of the two named first"),
                        ("nothing", "no effect named"), ("outside", "no effect named that is not there")):
        right, of = counts[group]
        print(f"{group:9}{right:3d} of {of:3d}  {text}")
    return 0 if all(counts[group][0] == counts[group][1] for group in ("single", "nothing")) else 1


if __name__ == "__main__":
    sys.exit(main())
