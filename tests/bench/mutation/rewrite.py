# SPDX-License-Identifier: Apache-2.0
"""Chooses mutants and writes all of them into one copy of the sources.

An expression becomes (active(n) ? changed : original), a statement { if (!active(n)) { ... } }; lines stay lines. What
is built of the copy is every mutant: the environment says which one runs (active.h).
"""

import collections
import pathlib
import re
import shutil
import subprocess

import sites

# Most constants are digits of a table of objects.
WEIGHTS = {"constant": 0.4}
INCLUDE = '#include "tests/bench/mutation/active.h"'


def choose(found, quotas, seed, refused=()):
    """The sites of the mutants, by number from 1: of each folder as many as `quotas` says, drawn from its files and the
    kinds of change in proportion to what they offer. The same for the same seed; lines and files that move change
    nothing."""
    ranked = []
    again = collections.Counter()
    buckets = collections.defaultdict(list)
    for site in found:
        again[site.key()] += 1
        buckets[(str(pathlib.PurePath(site.path).parent), site.kind)].append((site.rank(seed, again[site.key()]), site))
    for (_, kind), bucket in buckets.items():
        share = len(bucket) * WEIGHTS.get(kind, 1.0)
        bucket.sort(key=lambda pair: pair[0])
        offset = int(bucket[0][0][-8:], 16) / 2.0**32
        for place, (rank, site) in enumerate(bucket):
            ranked.append(((place + offset) / share, rank, site))
    ranked.sort(key=lambda one: one[:2])
    chosen = []
    for folder, quota in quotas.items():
        names = set()
        for _, _, site in ranked:
            if len(names) == quota:
                break
            # Of two equal changes in one function one is enough.
            if site.path.startswith(folder + "/") and site.key() not in names and site.key() not in refused:
                names.add(site.key())
                chosen.append(site)
    return {number + 1: site for number, site in enumerate(sorted(chosen, key=lambda s: (s.path, s.begin, s.kind)))}


def rewritten(text, numbered):
    """The file's text (bytes) with its mutants in it; `numbered`: (number, site)."""

    def render(begin, end, inner):
        out, at = b"", begin
        while inner:
            site = inner[0][1]
            # All at this place, then what lies within it.
            here = [one for one in inner if (one[1].begin, one[1].end) == (site.begin, site.end)]
            within = [one for one in inner if one not in here and one[1].begin < site.end]
            inner = [one for one in inner if one not in here and one not in within]
            body = render(site.begin, site.end, within)
            for number, one in here:
                body = changed(number, one, body)
            out += text[at:site.begin] + body
            at = site.end
        return out + text[at:end]

    order = sorted(numbered, key=lambda one: (one[1].begin, -one[1].end, one[0]))
    result = render(0, len(text), order).decode()
    assert result.count("\n") == text.decode().count("\n"), "lines moved"
    if "#pragma once" in result:
        return result.replace("#pragma once", "#pragma once\n" + INCLUDE, 1).encode()
    return result.replace('#include "', INCLUDE + '\n#include "', 1).encode()


def changed(number, site, body):
    if site.kind == "statement":
        # A statement of other statements on its line: a comment behind it stays outside.
        return f"{{ if (!::slipstack::mutation::active({number})) {{ ".encode() + body + b" } }"
    return f"(::slipstack::mutation::active({number}) ? {site.changed} : ".encode() + body + b")"


def write(root, mutants):
    """Puts the mutants into the headers below `root`, which is a copy."""
    by_path = collections.defaultdict(list)
    for number, site in mutants.items():
        by_path[site.path].append((number, site))
    for path, numbered in by_path.items():
        file = pathlib.Path(root) / path
        file.write_bytes(rewritten(file.read_bytes(), numbered))


def copy_sources(source, target, below=""):
    """What git knows of the project, as it is on disk; only what lies `below` a folder where one is named."""
    names = subprocess.run(["git", "-C", source, "ls-files"], check=True, capture_output=True, text=True).stdout.split("\n")
    target = pathlib.Path(target)
    for name in names:
        file = pathlib.Path(source) / name
        if not name or not name.startswith(below) or not file.is_file():
            continue
        there = target / name
        there.parent.mkdir(parents=True, exist_ok=True)
        # What is the same keeps its time: what is built of it stands.
        if not there.exists() or there.read_bytes() != file.read_bytes():
            shutil.copy(file, there)


def offenders(root, mutants, errors):
    """The mutants on the lines that a compiler complains about: '<path>:<line>: error'; one line was added to a file."""
    lines = {(path, int(line) - 1) for path, line in re.findall(r"([\w/.-]+):(\d+):\d+: error", errors)}
    lines |= {(path, int(line) - 1) for path, line in re.findall(r"([\w/.-]+):(\d+):\d+:   required", errors)}
    root = str(root) + "/"
    lines = {(path.removeprefix(root), line) for path, line in lines}
    return [number for number, site in mutants.items()
            if any((site.path, line) in lines for line in range(site.line, site.line + 1 + site.original.count("\n")))]


def choose_all(found, quotas, seeds, refused=()):
    """The mutants of several samples, by number from 1, and the numbers in each, by seed."""
    chosen = {seed: list(choose(found, quotas, seed, refused).values()) for seed in seeds}
    places = {(site.path, site.begin, site.end, site.changed): site for sites_of in chosen.values() for site in sites_of}
    order = sorted(places.values(), key=lambda s: (s.path, s.begin, s.kind, s.changed))
    number_of = {(site.path, site.begin, site.end, site.changed): number + 1 for number, site in enumerate(order)}
    samples = {seed: sorted(number_of[(s.path, s.begin, s.end, s.changed)] for s in chosen[seed]) for seed in seeds}
    return {number + 1: site for number, site in enumerate(order)}, samples


def accepted(source, target, found, quotas, seeds, compilers, refused=()):
    """The chosen mutants that the compiler takes, written into `target`, and the numbers of each seed's. `compilers`:
    commands that check the syntax of what includes the headers, with the folder as their place. A mutant that they
    refuse gives way to the next."""
    refused = set(refused)
    for _ in range(20):
        mutants, samples = choose_all(found, quotas, seeds, refused)
        for path in {site.path for site in found}:
            shutil.copy(pathlib.Path(source) / path, pathlib.Path(target) / path)
        write(target, mutants)
        errors = ""
        for command in compilers:
            done = subprocess.run(command, cwd=target, capture_output=True, text=True)
            if done.returncode != 0:
                errors += done.stderr
        if not errors:
            return mutants, samples, refused
        bad = offenders(target, mutants, errors)
        if not bad:
            raise RuntimeError(errors[:4000])
        refused |= {mutants[number].key() for number in bad}
    raise RuntimeError("mutants are refused again and again")
