#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the diagnosis fares on logs of rotary machines: robot joints, bare motors, torque rigs.

    tests/bench/blind/joint_generator.py [--slipstack PROGRAM] [--logs N] [--first-seed S] [--keep FOLDER] [--only WORD]

Machines: a joint behind a strain-wave gear (its loss as LuGre of arctangent level, viscous friction, 2 cycles of torque a turn of
the motor), a bare brushless motor, a rig with a torque sensor between drive and test bearing. Units position_rad, _deg
or _rev, torque_Nm or current_A; 100 Hz to 4 kHz; motion by sums of sines (as excitation trajectories of robots are),
point to point, slow sweeps at several speeds, or a repeated trajectory; the torque is that of the motor, with
noise, or follows from the current. Hidden: nothing, one effect in a form that physics gives, two, or a cause that no
effect of the catalogue is. A hidden torque that is added has an rms of 0.3 to 1.2 of the dry friction's level.

Prints a line for each log, then counts. Needs python3-numpy. Status 1 when anything is named on a log without a hidden
effect.
"""

import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import judged_logs  # noqa: E402

# case: effects that a right answer may name first, or coordinates of what is unexplained
SINGLES = {
    "viscous": {"viscous"}, "viscous:thinning": {"viscous", "quadratic_drag", "stribeck"},
    "stribeck": {"stribeck"}, "gravity": {"cable_chain_stiffness", "force_ripple", "offset_force"},
    "unbalance:turns": {"force_ripple"}, "cogging": {"force_ripple"}, "wave_generator": {"force_ripple"},
    "torque_constant": {"motor_constant_ripple"}, "load_inertia": {"payload_mass"}, "flexible_link": {"structural_resonance"},
    "late_current": {"time_delay"}, "direction": {"direction_asymmetry"}, "sensor_offset": {"offset_force"},
    "warming": {"drift"}, "eccentric_preload": {"position_dependent_preload"}, "fan_drag": {"quadratic_drag"},
}
PAIRS = [("viscous", "cogging"), ("gravity", "viscous"), ("load_inertia", "direction"), ("stribeck", "wave_generator")]
OUTSIDE = {"hum": {"frequency"}, "gear_play": {"reversal", "acceleration"}, "knock": {"position"}, "touched": {"time"}}
CASES = [()] * 4 + [(name,) for name in SINGLES] + PAIRS + [(name,) for name in OUTSIDE]


def filtered(signal, corner_Hz, rate_Hz):
    keep = math.exp(-2 * math.pi * corner_Hz / rate_Hz)
    out, y = numpy.empty(len(signal)), float(signal[0])
    for i, u in enumerate(signal):
        y = keep * y + (1 - keep) * u
        out[i] = y
    return out


def quintic(u):
    u = numpy.clip(u, 0.0, 1.0)
    return u ** 3 * (10 - 15 * u + 6 * u ** 2)


def motion(rng, kind, t, stroke, top):
    """Angle over time [rad]."""
    if kind == "sines":  # Swevers et al. 1997: harmonics of one base frequency
        base = rng.uniform(0.05, 0.12)
        q = sum(rng.normal() / k * numpy.sin(2 * math.pi * base * k * t + rng.uniform(0, 6.28)) for k in range(1, 7))
    elif kind == "repeated":
        period, q = rng.uniform(3.0, 6.0), numpy.zeros(len(t))
        u = (t % period) / period
        q = quintic(u / 0.35) - quintic((u - 0.5) / 0.35)
    elif kind == "sweeps":  # back and forth at a constant speed, each pair faster
        q, at, side = numpy.zeros(len(t)), 0.0, 0.0
        speeds = top * numpy.geomspace(0.02, 1.0, 8)
        share = stroke / speeds / (2 * (stroke / speeds).sum()) * t[-1]
        knots, values = [0.0], [0.0]
        for s in share:
            for target in (1.0, 0.0):
                knots.append(knots[-1] + s)
                values.append(target)
        q = numpy.interp(t, knots, values)
        width = max(3, int(0.15 / (t[1] - t[0])))
        for _ in range(2):
            q = numpy.convolve(numpy.pad(q, width, mode="edge"), numpy.ones(width) / width, "same")[width:-width]
    else:  # point to point with dwells
        q, now, start = numpy.zeros(len(t)), 0.0, 0.5
        while start < t[-1]:
            goal, take = rng.uniform(0, 1), rng.uniform(0.4, 1.6)
            q += (goal - now) * quintic((t - start) / take)
            now, start = goal, start + take + rng.uniform(0.1, 0.8)
    q = (q - q.min()) / (q.max() - q.min()) * stroke
    speed = numpy.abs(numpy.gradient(q, t)).max()
    return q, speed


def friction(q, dt, level, distance):
    """LuGre without its dampings (a Dahl deflection of first order) towards a level for each sample."""
    z, out = 0.0, numpy.empty(len(q))
    step = numpy.diff(q, prepend=q[0])
    for i, d in enumerate(step):
        end = math.copysign(1.0, d) if d else 0.0
        z = end + (z - end) * math.exp(-abs(d) / distance)
        out[i] = z * level[i]
    return out


def scaled(signal, rms):
    return signal * rms / max(float(numpy.sqrt(numpy.mean((signal - signal.mean()) ** 2))), 1e-12)


def make_log(seed, hidden, path):
    rng = numpy.random.default_rng(40_000 + seed)
    machine = str(rng.choice(["joint", "motor", "rig"]))
    names = set(hidden)
    kinds = ["sines", "ptp", "repeated"] if names & {"load_inertia", "flexible_link", "late_current", "gear_play"} else ["sines", "ptp", "sweeps", "repeated"]
    kind = "sweeps" if names & {"stribeck", "viscous:thinning"} else str(rng.choice(kinds))
    turns = machine == "motor" or bool(names & {"unbalance:turns", "cogging", "torque_constant", "eccentric_preload"})
    stroke = rng.uniform(2.2, 5.0) * 2 * math.pi if turns else rng.uniform(0.8, 3.0)
    rate_Hz = int(rng.choice([100, 200, 500, 1000, 2000, 4000]))
    seconds = rng.uniform(30.0, 60.0)
    fine = max(1, 2000 // rate_Hz)
    dt = 1.0 / (rate_Hz * fine)
    t = numpy.arange(int(seconds / dt)) * dt
    q, _ = motion(rng, kind, t, stroke, rng.uniform(0.5, 2.0) * stroke)
    v = numpy.gradient(q, dt)
    a = numpy.gradient(v, dt)
    top = numpy.abs(v).max()
    dry = 10 ** rng.uniform(-2.0, 1.3)
    inertia = rng.uniform(0.3, 1.5) * dry / max(float(numpy.sqrt(numpy.mean(a ** 2))), 1e-9)
    size = dry * rng.uniform(0.3, 1.2)
    distance = rng.uniform(2e-4, 3e-3)
    level = numpy.full(len(t), dry)
    torque = inertia * a
    gravity_phase = rng.uniform(-0.6, 0.6)
    if "stribeck" in names:
        slow = rng.uniform(0.01, 0.04) * top
        level *= 1 + rng.uniform(0.3, 0.6) * numpy.exp(-(v / slow) ** 2)
    if "direction" in names:
        level *= 1 + rng.uniform(0.12, 0.25) * numpy.sign(v)
    if "warming" in names:
        level *= 1 + rng.uniform(0.4, 0.7) * numpy.exp(-t / rng.uniform(0.2, 0.4) / seconds)
    if "eccentric_preload" in names:
        level *= 1 + rng.uniform(0.25, 0.5) * numpy.sin(q * 2 * math.pi / stroke * rng.uniform(0.7, 1.3) + rng.uniform(0, 6.28))
    torque = torque + friction(q, dt, level, distance)
    # what belongs to the hidden effects
    if "viscous" in names:
        torque += scaled(v, size)
    if "viscous:thinning" in names:  # shear thinning, Carreau
        torque += scaled(v * (1 + (v / (0.2 * top)) ** 2) ** -0.2, size)
    if "fan_drag" in names:
        torque += scaled(v * numpy.abs(v), size)
    if "gravity" in names:
        torque += scaled(numpy.sin(q - stroke / 2 + gravity_phase), size)
    if "unbalance:turns" in names:
        torque += scaled(numpy.sin(q + gravity_phase), size)
    if "cogging" in names:
        slots = int(rng.choice([7, 12, 14]))
        torque += scaled(numpy.sin(slots * q) + 0.4 * numpy.sin(2 * slots * q + 1.0), size)
    if "wave_generator" in names:
        ratio = int(rng.choice([30, 50, 80]))
        torque += scaled(numpy.sin(2 * ratio * q + 0.5), size)
    if "sensor_offset" in names:
        torque += size
    if "load_inertia" in names:
        torque += 0.25 * inertia * a
    if "flexible_link" in names:
        w, zeta = 2 * math.pi * rng.uniform(6.0, min(20.0, rate_Hz / 12)), rng.uniform(0.01, 0.04)
        x, s, swing = 0.0, 0.0, numpy.empty(len(t))
        for i, u in enumerate(a):
            s += (-u - 2 * zeta * w * s - w * w * x) * dt
            x += s * dt
            swing[i] = -(2 * zeta * w * s + w * w * x)
        torque += 0.3 * inertia * swing
    if "hum" in names:
        torque += math.sqrt(2) * size * numpy.sin(2 * math.pi * rng.uniform(1.5, 9.0) * t)
    if "knock" in names:
        torque += 3 * size * numpy.exp(-((q - rng.uniform(0.3, 0.7) * stroke) / (0.01 * stroke)) ** 2)
    if "touched" in names:
        at = rng.uniform(0.3, 0.7) * seconds
        torque += numpy.where((t > at) & (t < at + 1.2), 4 * size * numpy.sin(math.pi * (t - at) / 1.2), 0.0)
    if "gear_play" in names:  # until the flank is crossed nothing of the load is felt, then it is hit
        load = torque.copy()
        side, until, hit = 1.0, -1.0, 0.0
        for i in range(len(t)):
            now = 1.0 if load[i] > 0 else -1.0
            if now != side:
                side, until = now, t[i] + rng.uniform(0.01, 0.03)
            if t[i] < until:
                torque[i] = 0.1 * load[i]
            elif t[i] < until + 0.012:
                torque[i] += 2.5 * side * dry * math.sin(math.pi * (t[i] - until) / 0.012)
    if "late_current" in names:
        torque = filtered(torque, rng.uniform(15.0, 40.0), 1.0 / dt)
    if "torque_constant" in names:
        torque = torque * (1 + rng.uniform(0.08, 0.15) * numpy.sin(6 * q + 0.7))
    every = slice(None, None, fine)
    t, q, torque = t[every], q[every], torque[every]
    torque = torque + dry * 10 ** rng.uniform(-2.2, -1.2) * rng.normal(size=len(t))
    step = 2 * math.pi / float(rng.choice([8192, 65536, 2 ** 20]))
    q = numpy.round(q / step) * step
    unit, factor = [("rad", 1.0), ("deg", 180 / math.pi), ("rev", 0.5 / math.pi)][rng.integers(3)]
    head = {"inertia_kg_m2": f"{inertia:.6g}"} if rng.random() < 0.6 or "load_inertia" in names else {}
    head["encoder_resolution_rad"] = f"{step:.8g}"
    with open(path, "w", encoding="ascii") as log:
        log.writelines(f"# {key}: {value}\n" for key, value in head.items())
        log.write(f"time_s,position_{unit},torque_Nm\n")
        numpy.savetxt(log, numpy.c_[t, q * factor, torque], fmt=["%.6f", "%.9f", "%.7g"], delimiter=",")
    return f"{machine}/{kind}", rate_Hz


def label(note):
    setting, rate_Hz = note
    return f"{setting:16}{rate_Hz:5d}"


GENERATOR = judged_logs.Generator("joint", CASES, SINGLES, OUTSIDE, make_log, label, options=("--stepwise",))

if __name__ == "__main__":
    sys.exit(GENERATOR.main(__doc__.splitlines()[0]))
