# SPDX-License-Identifier: Apache-2.0
"""Axes as other people write them: friction models of the literature, motions, hidden effects, disturbances.

Nothing here is shared with sim_host or the catalogue. Friction models are states that one step of displacement
carries on, their level scaled by what a hidden effect does to it. SI units.
"""

import math

import numpy


# ---- friction of the guideway: step(dx, v, dt, level) -> force, level 1 where nothing modulates it

class Dahl:
    """Dahl 1968: dF/dx = s (1 - F/Fc sign v)^i."""

    def __init__(self, rng, level_N, length_m):
        self.level_N, self.stiffness = level_N, level_N / length_m
        self.power, self.force_N = float(rng.choice([0.8, 1.0, 1.5])), 0.0

    def step(self, dx, v, dt, level):
        ratio = 1.0 - self.force_N / self.level_N * (1.0 if dx > 0 else -1.0)
        parts = 1 + int(abs(dx) * self.stiffness / self.level_N / 0.3)
        if parts > 40:
            self.force_N = math.copysign(self.level_N, dx)
        else:
            for _ in range(parts):
                self.force_N += self.stiffness * dx / parts * math.copysign(abs(ratio) ** self.power, ratio)
                ratio = 1.0 - self.force_N / self.level_N * (1.0 if dx > 0 else -1.0)
        return level * self.force_N


class LuGre:
    """Canudas de Wit 1995: dz/dt = v - s0 |v| z / g, F = s0 z + s1 dz/dt; z is exact for constant velocity."""

    def __init__(self, rng, level_N, length_m):
        self.level_N, self.s0, self.z = level_N, level_N / length_m, 0.0
        self.s1 = self.s0 * float(rng.uniform(2e-5, 2e-4))

    def step(self, dx, v, dt, level):
        steady = self.level_N * level / self.s0 * (1.0 if dx >= 0 else -1.0)
        before = self.z
        self.z = steady + (self.z - steady) * math.exp(-abs(dx / steady))
        return self.s0 * self.z + self.s1 * (self.z - before) / dt


class ElastoPlastic:
    """Dupont 2002: LuGre whose bristles are purely elastic below a break-away deflection."""

    def __init__(self, rng, level_N, length_m):
        self.level_N, self.s0, self.z = level_N, level_N / length_m, 0.0
        self.breakaway = float(rng.uniform(0.3, 0.7))

    def step(self, dx, v, dt, level):
        steady = self.level_N * level / self.s0
        parts = min(1 + int(abs(dx) / steady / 0.2), 60)
        for _ in range(parts):
            share = 0.0
            if self.z * dx > 0:
                u = (abs(self.z) / steady - self.breakaway) / (1.0 - self.breakaway)
                share = 0.0 if u <= 0 else 1.0 if u >= 1 else 0.5 * math.sin(math.pi * (u - 0.5)) + 0.5
            self.z += dx / parts - share * abs(dx / parts) * self.z / steady
            self.z = min(max(self.z, -steady), steady)
        return self.s0 * self.z


class BoucWen:
    """Bouc 1967, Wen 1976: dz = dx (1 - |z|^n (b sign(dx z) + c)), b + c = 1."""

    def __init__(self, rng, level_N, length_m):
        self.level_N, self.length_m, self.z = level_N, length_m, 0.0
        self.n, self.b = float(rng.choice([1.0, 1.5, 2.0])), float(rng.uniform(0.5, 0.8))

    def step(self, dx, v, dt, level):
        u = dx / self.length_m
        if abs(u) > 12:
            self.z = math.copysign(1.0, u)
        else:
            parts = 1 + int(abs(u) / 0.2)
            for _ in range(parts):
                side = 1.0 if u * self.z >= 0 else -1.0
                self.z += u / parts * (1.0 - abs(self.z) ** self.n * (self.b * side + 1.0 - self.b))
        return level * self.level_N * self.z


class Elements:
    """Stop operators in parallel: Maxwell slip with few elements, Iwan with Weibull slip forces."""

    def __init__(self, rng, level_N, length_m, kind):
        if kind == "uniform4":
            slip, share = length_m * numpy.array([0.5, 1.0, 1.5, 2.0]), rng.dirichlet(numpy.full(4, 3.0))
        elif kind == "geometric6":
            slip, share = length_m * numpy.geomspace(0.1, 4.0, 6), rng.dirichlet(numpy.full(6, 3.0))
        else:
            slip = length_m * rng.weibull(rng.uniform(0.8, 1.8), 80)
            share = numpy.full(80, 1.0 / 80)
        self.slip, self.stiffness = slip, level_N * share / slip
        self.deflection = numpy.zeros(len(slip))

    def step(self, dx, v, dt, level):
        deflection = self.deflection
        deflection += dx
        numpy.minimum(deflection, self.slip, out=deflection)
        numpy.maximum(deflection, -self.slip, out=deflection)
        return level * float(self.stiffness @ deflection)


class Gms:
    """Lampaert 2003: four elements that stick as springs and slip by dF/dt = C (share sign v - F/s)."""

    def __init__(self, rng, level_N, length_m):
        self.share = rng.dirichlet(numpy.full(4, 4.0)) * level_N
        self.stiffness = self.share / (length_m * numpy.array([0.2, 0.6, 1.5, 3.0]))
        self.force, self.rate = numpy.zeros(4), float(rng.uniform(1e3, 4e3))

    def step(self, dx, v, dt, level):
        top = self.share * level
        free = self.force + self.stiffness * dx
        slips = numpy.abs(free) > top
        goal = numpy.copysign(top, free)
        keep = math.exp(-self.rate * dt)
        self.force = numpy.where(slips & (numpy.abs(self.force) > top), goal + (self.force - goal) * keep,
                                 numpy.where(slips, goal, free))
        return float(self.force.sum())


class Leuven:
    """Swevers 2000: hysteresis with nonlocal memory of a bristle that creeps into sliding, dz = dx (1 - |F/level|^n)."""

    def __init__(self, rng, level_N, length_m):
        self.level_N, self.length_m, self.n = level_N, length_m, float(rng.choice([1.0, 2.0, 4.0]))
        self.ends, self.force_N = [(0.0, 0.0)], 0.0  # (z, force) where the bristle turned round
        self.z, self.side = 0.0, 0.0

    def branch(self):
        """Force on the branch that began at the last reversal: the virgin curve, doubled after the first."""
        z, force_N = self.ends[-1]
        twice = 1.0 if len(self.ends) == 1 else 2.0
        way = self.z - z
        return force_N + math.copysign(twice * 1.1 * self.level_N * -math.expm1(-abs(way) / (twice * self.length_m)), way)

    def step(self, dx, v, dt, level):
        parts = min(1 + int(abs(dx) / (0.2 * self.length_m)), 25)
        for _ in range(parts):
            ratio = self.force_N / (self.level_N * level)
            share = 1.0 - math.copysign(abs(ratio) ** self.n, ratio * dx)
            dz = dx / parts * max(share, 0.0)
            if dz * self.side < 0.0:
                self.ends.append((self.z, self.force_N))
            if dz:
                self.side = dz
            self.z += dz
            # A loop that closes is forgotten, with the reversal that began it.
            while len(self.ends) > 2 and (self.z - self.ends[-2][0]) * self.side > 0.0:
                del self.ends[-2:]
            self.force_N = self.branch()
            self.force_N = min(max(self.force_N, -self.level_N * level), self.level_N * level)
        return self.force_N


FRICTIONS = {"leuven": Leuven, "lugre": LuGre, "dahl": Dahl, "elastoplastic": ElastoPlastic, "boucwen": BoucWen, "gms": Gms,
             "uniform4": lambda *a: Elements(*a, "uniform4"), "geometric6": lambda *a: Elements(*a, "geometric6"),
             "iwan": lambda *a: Elements(*a, "iwan")}


# ---- motions: a reference over fine time

def rounded(pieces, step_s, first_s, second_s):
    """Positions of piecewise constant velocity, its corners rounded by two running means (an S-curve)."""
    v = numpy.concatenate([numpy.full(max(1, int(seconds / step_s)), speed) for speed, seconds in pieces])
    pad = int((first_s + second_s) / step_s) + 2
    v = numpy.concatenate([numpy.zeros(pad), v, numpy.zeros(pad)])
    for width_s in (first_s, second_s):
        width = max(1, int(width_s / step_s))
        total = numpy.cumsum(numpy.concatenate([numpy.zeros(width), v]))
        v = (total[width:] - total[:-width]) / width
    return numpy.cumsum(v) * step_s


def travel(pieces, step_s):
    """Positions that start where the one before ended."""
    out, at = [], 0.0
    for piece in pieces:
        out.append(at + piece - piece[0])
        at = float(out[-1][-1])
    return numpy.concatenate(out)


def smooth(u):
    """From 0 to 1, without a corner in velocity or acceleration."""
    u = numpy.clip(u, 0, 1)
    return u * u * u * (10 + u * (6 * u - 15))


def fade(n, share=0.08):
    u = numpy.arange(n) / n
    return smooth(u / share) * smooth((1 - u) / share)


def small_sines(rng, step_s):
    """Pre-sliding: slow sines of falling amplitude."""
    pieces = []
    for amplitude_m in (150e-6, 40e-6, 12e-6, 4e-6):
        t = numpy.arange(0.0, 2.5, step_s)
        pieces.append(amplitude_m * fade(len(t), 0.2) * numpy.sin(2 * numpy.pi * rng.uniform(0.8, 1.3) * t))
    return pieces


def point_to_point(rng, step_s, stroke_m):
    plan, at = [], 0.5 * stroke_m
    for _ in range(16):
        to = rng.uniform(0.08, 0.92) * stroke_m
        speed = rng.uniform(0.15, 0.9)
        plan += [(math.copysign(speed, to - at), abs(to - at) / speed), (0.0, rng.uniform(0.1, 0.3))]
        at = to
    return [rounded(plan, step_s, 0.06, 0.03)]


def jogs(rng, step_s, stroke_m):
    plan = []
    for speed in numpy.geomspace(5e-4, 0.35, 7):
        seconds = min(1.2, 0.35 * stroke_m / speed)
        plan += [(speed, seconds), (0.0, 0.1), (-speed, seconds), (0.0, 0.1)]
    return [rounded(plan, step_s, 0.03, 0.03)]


def multisine(rng, step_s, stroke_m):
    t = numpy.arange(0.0, 24.0, step_s)
    tones = numpy.array([0.1, 0.3, 0.7, 1.1, 1.7, 2.3, 3.1, 4.3])
    waves = sum(f ** -1.5 * numpy.sin(2 * numpy.pi * f * t + rng.uniform(0, 6.28)) for f in tones)
    return [0.4 * stroke_m * fade(len(t)) * waves / numpy.abs(waves).max()]


def chirp(rng, step_s, stroke_m):
    t = numpy.arange(0.0, 20.0, step_s)
    phase = 2 * numpy.pi * 0.15 * 20.0 / math.log(40.0) * (40.0 ** (t / 20.0) - 1.0)
    return [0.4 * stroke_m * fade(len(t)) * 30.0 ** (-t / 20.0) * numpy.sin(phase)]


def decreasing_sine(rng, step_s, stroke_m):
    t = numpy.arange(0.0, 30.0, step_s)
    return [0.4 * stroke_m * smooth(t / 2.0) * numpy.exp(-t / 3.3) * numpy.sin(2 * numpy.pi * 0.8 * t)]


def long_dwells(rng, step_s, stroke_m):
    plan, at = [], 0.0
    for _ in range(8):
        to = rng.uniform(-0.4, 0.4) * stroke_m
        plan += [(math.copysign(0.3, to - at), abs(to - at) / 0.3), (0.0, 3.0)]
        at = to
    return [rounded(plan, step_s, 0.08, 0.05)]


def presliding(rng, step_s, stroke_m):
    t = numpy.arange(0.0, 20.0, step_s)
    wave = numpy.sin(2 * numpy.pi * 0.5 * t) + 0.6 * numpy.sin(2 * numpy.pi * 1.3 * t + 1.0)
    return [rng.uniform(5e-6, 60e-6) * fade(len(t)) * wave]


def random_steps(rng, step_s, stroke_m):
    """Moves of a micrometre to most of the rail, each as fast as a drive would, with pauses of any length."""
    pieces, at = [], 0.5 * stroke_m
    for _ in range(40):
        way = 10 ** rng.uniform(-6, math.log10(0.6 * stroke_m)) * rng.choice([-1, 1])
        to = at + way if 0.05 * stroke_m < at + way < 0.95 * stroke_m else at - way
        if not 0.0 <= to <= stroke_m:
            continue
        move_s = 0.02 + abs(to - at) / 0.5
        u = numpy.arange(0.0, move_s + rng.uniform(0.05, 0.4), step_s) / move_s
        pieces.append(at + (to - at) * smooth(u))
        at = to
    return pieces


def mixed(rng, step_s, stroke_m):
    return point_to_point(rng, step_s, stroke_m) + small_sines(rng, step_s) + jogs(rng, step_s, stroke_m)


MOTIONS = {"p2p": point_to_point, "jogs": jogs, "multisine": multisine, "chirp": chirp, "decreasing": decreasing_sine,
           "dwells": long_dwells, "presliding": presliding, "mixed": mixed, "steps": random_steps}
