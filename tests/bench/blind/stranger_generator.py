#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the diagnosis fares on logs of strangers: friction models, controllers, motions and recorders of the literature.

    tests/bench/blind/stranger_generator.py [--slipstack PROGRAM] [--logs N] [--first-seed S] [--keep FOLDER] [--only WORD]

Base friction by LuGre, Dahl, elasto-plastic, Bouc-Wen, GMS, Leuven, Maxwell slip of four or six elements, Iwan with
Weibull; motion prescribed, by a PID with the friction in the loop, or by a sine of force alone; encoders of 1 nm to
5 um, 200 Hz to 20 kHz, force or current, quantised, saturated, white or coloured noise, jitter, lost samples. Effects in another form than the catalogue's, pairs,
nothing hidden, and what no effect of the catalogue is. `raised`: how far the hidden force, without what stop operators
and inertia imitate of it, raises the error over noise and over what they miss of the base friction (`misfit`, in
multiples of the noise).

Prints a line for each log, then counts. Needs python3-numpy. Status 1 when anything is named on a log without a hidden
effect.
"""

import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import judged_logs  # noqa: E402
import stranger_physics as physics  # noqa: E402

# case: effects that a right answer may name first, or coordinates of what is unexplained
SINGLES = {
    "viscous": {"viscous"}, "viscous:power": {"viscous"}, "quadratic_drag": {"quadratic_drag"},
    "stribeck:gauss": {"stribeck"}, "stribeck:lorentz": {"stribeck"}, "stribeck:tustin": {"stribeck"},
    "frictional_lag:delay": {"frictional_lag"},
    "position_dependent_preload:spots": {"position_dependent_preload"},
    "position_dependent_preload:slope": {"position_dependent_preload"},
    "acceleration_dependent_preload": {"acceleration_dependent_preload"},
    "direction_asymmetry": {"direction_asymmetry"}, "direction_asymmetry:viscous": {"direction_asymmetry"},
    "force_ripple": {"force_ripple"}, "force_ripple:harmonics": {"force_ripple"},
    "motor_constant_ripple": {"motor_constant_ripple"}, "offset_force:tilt": {"offset_force"},
    "cable_chain_stiffness": {"cable_chain_stiffness"}, "payload_mass": {"payload_mass"},
    "structural_resonance": {"structural_resonance"}, "time_delay:transport": {"time_delay"},
    "time_delay:filter": {"time_delay"}, "drift:warming": {"drift"}, "drift:linear": {"drift"},
}
PAIRS = [("viscous", "direction_asymmetry"), ("stribeck:gauss", "force_ripple"), ("payload_mass", "viscous"),
         ("offset_force:tilt", "position_dependent_preload:spots"), ("drift:warming", "quadratic_drag")]
OUTSIDE = {"hum": {"frequency"}, "neighbour": {"frequency"}, "bump": {"position"}, "backlash": {"reversal", "acceleration"},
           "encoder_slip": {"time", "position"}, "burst": {"time"}, "snag_once": {"time", "position"},
           "loose_coupling": {"reversal", "acceleration", "velocity"}, "controller_glitches": {"time"},
           "random_walk": {"time"}}
CASES = ([()] * 6 + [(name,) for name in SINGLES] + PAIRS + [(name,) for name in OUTSIDE])
MOTION_OF = {"stribeck": ["jogs", "mixed", "decreasing"], "frictional_lag": ["mixed", "decreasing", "multisine"],
             "presliding": ["presliding"]}
FAST = ["p2p", "multisine", "mixed", "chirp", "steps"]


class Hidden:
    """The hidden forces of one log, asked sample by sample with the true motion."""

    def __init__(self, rng, names, axis):
        self.names, self.rng, self.axis = set(names), rng, axis
        level, stroke, top = axis["level_N"], axis["stroke_m"], axis["top_mps"]
        self.size = level * rng.uniform(0.12, 0.35)
        self.pitch = float(rng.choice([0.012, 0.016, 0.024, 0.03]))
        self.phase = rng.uniform(0, 6.28, 8)
        self.spots = [(rng.uniform(0.1, 0.9) * stroke + axis["low_m"], rng.uniform(0.05, 0.15) * stroke,
                       rng.uniform(0.2, 0.5) * rng.choice([-1, 1])) for _ in range(4)]
        self.vs = float(numpy.clip(top * rng.uniform(0.005, 0.03), 2e-4, 8e-3))
        self.weak = rng.uniform(0.2, 0.4)
        self.lag = rng.uniform(0.01, 0.03)
        self.arm_Hz, self.arm = rng.uniform(20, 60), rng.uniform(0.15, 0.4)
        self.q, self.rate = 0.0, 0.0
        self.past, self.walk = [], 0.0
        self.event_s = rng.uniform(0.3, 0.7) * axis["seconds"]
        self.flank, self.since = 0.0, 1e9

    def level(self, t, x, v, a, dt):
        n, f = self.names, 1.0
        for form in ("gauss", "lorentz", "tustin"):
            if f"stribeck:{form}" in n:
                u = v / self.vs
                fall = {"gauss": math.exp(-min(u * u, 50)), "lorentz": 1 / (1 + u * u), "tustin": math.exp(-min(abs(u), 50))}[form]
                f *= 1 - self.weak * (1 - fall)
        if "frictional_lag:delay" in n:
            self.past.append(abs(v))
            back = int(self.lag / dt)
            u = (self.past[-1 - back] if len(self.past) > back else 0.0) / (4 * self.vs)
            f *= 1 - self.weak * (1 - math.exp(-min(u * u, 50)))
        if "position_dependent_preload:spots" in n:
            f *= 1 + sum(h * math.exp(-((x - c) / w) ** 2) for c, w, h in self.spots)
        if "position_dependent_preload:slope" in n:
            f *= 1 + 0.5 * ((x - self.axis["low_m"]) / self.axis["stroke_m"] - 0.5)
        if "acceleration_dependent_preload" in n:
            f *= 1 + 0.5 * math.sqrt(a * a + (0.02 * self.axis["top_mps2"]) ** 2) / self.axis["top_mps2"]
        if "direction_asymmetry" in n:
            f *= 1.12 if v > 0 else 0.88
        if "drift:warming" in n:
            f *= 1 + 0.35 * math.exp(-t / (0.3 * self.axis["seconds"]))
        if "drift:linear" in n:
            f *= 1 - 0.3 * t / self.axis["seconds"]
        return f

    def force(self, t, x, v, a, dt, friction_N):
        n, size, top, f = self.names, self.size, self.axis["top_mps"], 0.0
        stroke, low = self.axis["stroke_m"], self.axis["low_m"]
        if "viscous" in n:
            f += 2 * size * v / top
        if "viscous:power" in n:
            f += 1.7 * size * math.copysign(abs(v / top) ** 0.8, v)
        if "quadratic_drag" in n:
            f += 2.5 * size * v * abs(v) / top ** 2
        if "direction_asymmetry:viscous" in n:
            f += 1.5 * size * (v / top if v > 0 else 0.2 * v / top) + 0.3 * size * math.tanh(v / 1e-4) * (v > 0)
        if "force_ripple" in n:
            f += size * math.sin(2 * math.pi * x / self.pitch + self.phase[0])
        if "force_ripple:harmonics" in n:
            f += sum(size * w * math.sin(2 * math.pi * k * x / self.pitch + self.phase[k]) for k, w in ((1, 0.8), (2, 0.5), (6, 0.3)))
        if "offset_force:tilt" in n:
            f += size
        if "cable_chain_stiffness" in n:
            u = (x - low) / stroke - 0.4
            f += 2 * size * (u + 0.2 * u ** 3)
        if "payload_mass" in n:
            f += 0.15 * self.axis["mass_kg"] * a
        if "structural_resonance" in n:
            w = 2 * math.pi * self.arm_Hz
            for _ in range(2):
                swing = -a - w * w * self.q - 0.05 * w * self.rate
                self.rate += swing * dt / 2
                self.q += self.rate * dt / 2
            f += self.arm * self.axis["mass_kg"] * (-(w * w * self.q + 0.05 * w * self.rate))
        if "hum" in n:
            f += size * math.sin(2 * math.pi * 50.0 * t)
        if "neighbour" in n:
            f += size * math.sin(2 * math.pi * 7.3 * t + 1.0)
        if "bump" in n:
            f += 2.5 * size * math.exp(-((x - low - 0.5 * stroke) / 3e-3) ** 2) * math.tanh(v / 1e-4)
        if "burst" in n and self.event_s < t < self.event_s + 0.4:
            f += 4 * size * self.rng.normal()
        if "snag_once" in n and 0 < t - self.event_s < 0.8:
            f += 4 * size * math.sin(math.pi * (t - self.event_s) / 0.8) ** 2
        if "random_walk" in n:
            self.walk += 0.5 * size * self.rng.normal() * math.sqrt(dt)
            f += self.walk
        if "controller_glitches" in n and (t / self.axis["seconds"] * 7) % 1.0 < 0.003:
            f += 8 * size
        if "backlash" in n or "loose_coupling" in n:
            side = 1.0 if a * self.axis["mass_kg"] + friction_N > 0 else -1.0
            if side != self.flank:
                self.flank, self.since, self.hit = side, 0.0, size * min(3.0, 1.0 + abs(v) / top)
            self.since += dt
            if "backlash" in n:
                f += 4 * self.flank * self.hit * math.exp(-self.since / 0.004) * math.sin(2 * math.pi * 90 * self.since)
            elif self.since < 0.012:
                f -= 0.8 * (a * self.axis["mass_kg"] + friction_N)
        return f


def sampled(rng, axis, kind, friction, hidden, fine_Hz):
    """Prescribed motion: arrays t, x, force, base friction + inertia, at fine steps."""
    x = axis["reference_m"]
    dt = 1.0 / fine_Hz
    v = numpy.gradient(x, dt)
    a = numpy.gradient(v, dt)
    force, bare = numpy.empty(len(x)), numpy.empty(len(x))
    twin = axis["friction"]()
    m, last = axis["mass_kg"], x[0]
    for i in range(len(x)):
        xi, vi, ai, t = float(x[i]), float(v[i]), float(a[i]), i * dt
        dx, last = xi - last, xi
        fr = friction.step(dx, vi, dt, hidden.level(t, xi, vi, ai, dt))
        bare[i] = (twin.step(dx, vi, dt, 1.0) if hidden.names else fr) + m * ai
        force[i] = fr + m * ai + hidden.force(t, xi, vi, ai, dt, fr)
    return x, v, a, force, bare


class LostControl(Exception):
    """The controller that was drawn does not hold the axis that was drawn."""


def looped(rng, axis, kind, friction, hidden, fine_Hz, control_every):
    """PID with feed-forward of mass; the force is what the motor gives, constant between control ticks. Raises LostControl."""
    ref = axis["reference_m"]
    dt = 1.0 / fine_Hz
    rv = numpy.gradient(ref, dt)
    ra = numpy.gradient(rv, dt)
    m, w = axis["mass_kg"], 2 * math.pi * rng.uniform(12, 25)
    kp, kd, ki = 3 * m * w * w, 3 * m * w, m * w ** 3
    step = axis["encoder_m"]
    T = dt * control_every
    x, v, a, integral, seen, slope, u = float(ref[0]), 0.0, 0.0, 0.0, float(ref[0]), 0.0, 0.0
    out = numpy.empty((5, len(ref)))
    twin, before = axis["friction"](), 0.0
    last, fr = x, 0.0
    for i in range(len(ref)):
        t = i * dt
        if i % control_every == 0:
            y = round(x / step) * step
            slope += (1.0 - math.exp(-2 * math.pi * 150.0 * T)) * ((y - seen) / T - slope)
            seen = y
            e = float(ref[i]) - y
            if abs(e) > axis["stroke_m"]:
                raise LostControl
            integral += e * T
            before = u
            u = m * float(ra[i]) + kp * e + ki * integral + kd * (float(rv[i]) - slope)
        fr = friction.step(x - last, v, dt, hidden.level(t, x, v, a, dt))
        same = twin.step(x - last, v, dt, 1.0) if hidden.names else fr
        last = x
        f = hidden.force(t, x, v, a, dt, fr)
        a = (u - fr - f) / m
        # the current as a drive measures it: between what it was and what it will be
        seen_N = ((control_every - 1) * before + control_every * u) / (2 * control_every - 1)
        out[:, i] = x, v, a, seen_N, seen_N - (fr + f - same)
        v += a * dt
        x += v * dt
    return tuple(out)


def forced(rng, axis, friction, hidden, fine_Hz, seconds):
    """No controller: a sine of force with slowly varying amplitude moves the mass; x, v, a, force, bare as above."""
    dt, m = 1.0 / fine_Hz, axis["mass_kg"]
    twin, out = axis["friction"](), numpy.empty((5, int(seconds * fine_Hz)))
    x, v, a, last, fr = 0.0, 0.0, 0.0, 0.0, 0.0
    w, depth, top = axis["sine_Hz"] * 2 * math.pi, axis["sine_depth"], axis["sine_N"]
    for i in range(out.shape[1]):
        t = i * dt
        u = top * (1.0 - depth * (0.5 - 0.5 * math.cos(2 * math.pi * t / (0.25 * seconds)))) * math.cos(w * t) - axis["spring_Npm"] * x
        fr = friction.step(x - last, v, dt, hidden.level(t, x, v, a, dt))
        same = twin.step(x - last, v, dt, 1.0) if hidden.names else fr
        last = x
        f = hidden.force(t, x, v, a, dt, fr)
        a = (u - fr - f) / m
        out[:, i] = x, v, a, u, u - (fr + f - same)
        v += a * dt
        x += v * dt
    return tuple(out)


def beyond_imitation(x, a, force_N, other_N):
    """Rms of a force, and of another, without what inertia and stop operators imitate."""
    slip = numpy.geomspace(3e-8, 2e-3, 28)
    deflection = numpy.zeros(28)
    thin = max(1, len(x) // 40000)
    x, a, force_N, other_N = x[::thin], a[::thin], force_N[::thin], other_N[::thin]
    rows = numpy.empty((len(x), 29))
    for i, dx in enumerate(numpy.diff(x, prepend=x[0])):
        deflection = numpy.clip(deflection + dx, -slip, slip)
        rows[i, :28] = deflection / slip
    rows[:, 28] = a
    left = []
    for f in (force_N, other_N):
        g = numpy.linalg.lstsq(rows, f, rcond=None)[0]
        left.append(float(numpy.sqrt(numpy.mean((f - rows @ g) ** 2))))
    return left


def make_log(seed, hidden_names, path):
    """Writes a log and says how it was made; of the next draw where the controller loses the axis."""
    draw = 0
    while True:
        try:
            return drawn_log(numpy.random.default_rng([1000 + seed, draw] if draw else 1000 + seed), hidden_names, path)
        except LostControl:
            draw += 1


def drawn_log(rng, hidden_names, path):
    root = hidden_names[0].split(":")[0] if hidden_names else ""
    choices = MOTION_OF.get(root, FAST if root in ("payload_mass", "acceleration_dependent_preload", "structural_resonance",
                                                   "time_delay", "quadratic_drag", "backlash", "loose_coupling")
                            else list(physics.MOTIONS) if not hidden_names else [k for k in physics.MOTIONS if k != "presliding"])
    kind = str(rng.choice(choices if root in MOTION_OF else choices + ["forced"]))
    name = str(rng.choice(list(physics.FRICTIONS)))
    closed = bool(rng.random() < 0.3) and kind not in ("presliding", "forced") and not {"time_delay:transport", "time_delay:filter", "encoder_slip"} & set(hidden_names)
    rate_Hz = int(rng.choice([200, 500, 1000, 2000, 4000, 10000, 20000], p=[0.05, 0.1, 0.2, 0.3, 0.2, 0.1, 0.05]))
    fine_Hz = max(rate_Hz, 8000) * (2 if closed else 1)
    stroke_m = rng.uniform(0.08, 0.7)
    mass_kg, level_N = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(0.3, 1.8)
    level_N = max(level_N, 0.4 * mass_kg)  # rails preloaded in proportion, or friction is lost in inertia
    length_m = 10 ** rng.uniform(-5.5, -4.4)
    make_friction = physics.FRICTIONS[name]
    friction_seed = int(rng.integers(1 << 30))
    axis = {"friction": lambda: make_friction(numpy.random.default_rng(friction_seed), level_N, length_m), "mass_kg": mass_kg}
    if kind == "forced":
        # The spring of the fixture brings it back: half its own frequency, so that the sine moves it.
        sine_Hz, way_m, seconds = rng.uniform(0.8, 4.0), 0.12 * stroke_m, 20.0
        w2 = (2 * math.pi * sine_Hz) ** 2
        axis.update(sine_Hz=sine_Hz, sine_depth=rng.uniform(0.2, 0.6), spring_Npm=0.25 * mass_kg * w2,
                    sine_N=0.75 * mass_kg * w2 * way_m + 1.6 * level_N)
        axis.update(level_N=level_N, stroke_m=stroke_m, low_m=-0.5 * stroke_m, top_mps=1.0, top_mps2=1.0, seconds=seconds)
        ref = forced(rng, axis, axis["friction"](), Hidden(numpy.random.default_rng(0), [], axis), fine_Hz, seconds)[0]
    else:
        ref = 0.5 * stroke_m + physics.travel(physics.MOTIONS[kind](rng, 1.0 / fine_Hz, stroke_m), 1.0 / fine_Hz)
    v = numpy.gradient(ref, 1.0 / fine_Hz)
    top = float(numpy.abs(v).max())
    axis |= {"level_N": level_N, "stroke_m": float(numpy.ptp(ref)), "low_m": float(ref.min()), "top_mps": top, "mass_kg": mass_kg,
            "top_mps2": float(numpy.abs(numpy.gradient(v, 1.0 / fine_Hz)).max()), "seconds": len(ref) / fine_Hz,
            "reference_m": ref, "encoder_m": float(rng.choice([1e-9, 1e-8, 1e-7, 1e-6, 5e-6], p=[0.1, 0.25, 0.35, 0.2, 0.1]))}
    if closed:
        axis["encoder_m"] = min(axis["encoder_m"], 1e-6)
    if kind == "presliding":
        axis["encoder_m"] = min(axis["encoder_m"], 1e-8)
    hidden = Hidden(rng, hidden_names, axis)
    if kind == "forced":
        x, v, a, force, bare = forced(rng, axis, axis["friction"](), hidden, fine_Hz, axis["seconds"])
    elif closed:
        x, v, a, force, bare = looped(rng, axis, kind, axis["friction"](), hidden, fine_Hz, fine_Hz // max(rate_Hz, 4000))
    else:
        x, v, a, force, bare = sampled(rng, axis, kind, axis["friction"](), hidden, fine_Hz)
    every = fine_Hz // rate_Hz
    t_fine = numpy.arange(len(x)) / fine_Hz
    names = set(hidden_names)
    clean_force = force.copy()
    if "time_delay:transport" in names:
        force = numpy.interp(t_fine - rng.uniform(1.5e-3, 5e-3), t_fine, force)
    if "time_delay:filter" in names:
        keep = math.exp(-1.0 / fine_Hz / rng.uniform(2e-3, 4e-3))
        y, late = float(force[0]), numpy.empty(len(force))
        for i, f in enumerate(force):
            y = keep * y + (1 - keep) * f
            late[i] = y
        force = late
    if "motor_constant_ripple" in names:
        force = force / (1 + 0.07 * numpy.sin(2 * numpy.pi * x / hidden.pitch + hidden.phase[0]))
    del clean_force
    t, xs, fs, a_s, bs = (u[::every] for u in (t_fine, x, force, a, bare))
    noise_N = level_N * 10 ** rng.uniform(-2.7, -1.7)
    noise = noise_N * rng.normal(size=len(t))
    if rng.random() < 0.25:  # coloured: half the power below some 100 Hz
        slow, y, keep = numpy.empty(len(t)), 0.0, math.exp(-2 * math.pi * 100.0 / rate_Hz)
        for i, w in enumerate(rng.normal(size=len(t))):
            y = keep * y + math.sqrt(1 - keep * keep) * w
            slow[i] = y
        noise = math.sqrt(0.5) * (noise + noise_N * slow)
    left_N, misfit_N = beyond_imitation(xs, a_s, fs - bs, bs)
    raised = math.hypot(1.0, left_N / math.hypot(noise_N, misfit_N))
    measured = fs + noise
    if rng.random() < 0.07:  # the amplifier's end of range
        top_N = 0.85 * numpy.abs(measured).max()
        measured = numpy.clip(measured, -top_N, top_N)
    xm = xs.copy()
    if "encoder_slip" in names:
        xm[t > hidden.event_s] += 40 * max(axis["encoder_m"], 2e-6)
    write_log(rng, path, axis, t, xm, measured, hidden)
    return f"{name}/{kind}{'/pid' if closed else ''}", rate_Hz, axis["encoder_m"], raised, misfit_N / noise_N


def write_log(rng, path, axis, t, x, force, hidden):
    """One of the ways in which recorders write."""
    step = axis["encoder_m"]
    head = {"mass_kg": f"{axis['mass_kg']:.6g}"} if rng.random() < 0.8 or "payload_mass" in hidden.names else {}
    if rng.random() < 0.7:
        head["encoder_resolution_m"] = f"{step:g}"
    if rng.random() < 0.4:
        head["magnet_pitch_m"] = "0.024"
    counts = numpy.round(x / step)
    unit = str(rng.choice(["m", "mm", "um", "counts"] if "encoder_resolution_m" in head else ["m", "mm", "um"]))
    position = counts if unit == "counts" else counts * step * {"m": 1, "mm": 1e3, "um": 1e6}[unit]
    digits = {"m": 10, "mm": 7, "um": 4, "counts": 0}[unit]
    if rng.random() < 0.4:
        constant = rng.uniform(5, 80)
        head["motor_constant_N_per_A"] = f"{constant:.5g}"
        constant = float(head["motor_constant_N_per_A"])
        lsb = 20 * numpy.abs(force).max() / constant / 2 ** 16 / 10
        column, values = "current_A", numpy.round(force / constant / lsb) * lsb
    else:
        column, values = "force_N", force
    stamps = t + (float(rng.uniform(0, 5000)) if rng.random() < 0.3 else 0.0)
    keep = numpy.ones(len(t), bool)
    if rng.random() < 0.15:
        head["sampling"] = "irregular"
        if rng.random() < 0.5:
            keep = rng.random(len(t)) > 0.002
        else:
            stamps = stamps + (t[1] - t[0]) * rng.uniform(-0.03, 0.03, len(t))
    with open(path, "w", encoding="ascii") as log:
        log.writelines(f"# {key}: {value}\n" for key, value in head.items())
        log.write(f"time_s,position_{unit},{column}\n")
        numpy.savetxt(log, numpy.c_[stamps, position, values][keep], fmt=["%.7f", f"%.{digits}f", "%.7g"], delimiter=",")


def label(note):
    setting, rate_Hz, encoder_m, raised, misfit = note
    return f"{setting:26}{rate_Hz:6d} {encoder_m:6.0e}{raised:7.2f}{misfit:6.1f}"


GENERATOR = judged_logs.Generator("stranger", CASES, SINGLES, OUTSIDE, make_log, label, counted=lambda note: note[3] >= 1.1, width=50)

if __name__ == "__main__":
    sys.exit(GENERATOR.main(__doc__.splitlines()[0]))
