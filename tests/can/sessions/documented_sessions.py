# SPDX-License-Identifier: Apache-2.0
"""docs/can-sessions.md from a real capture.

    python3 tests/can/sessions/documented_sessions.py            checks that the page shows what the programs do now
    python3 tests/can/sessions/documented_sessions.py --write    writes the page anew
    python3 tests/can/sessions/documented_sessions.py --update   the same, where the check fails or the model has another size

Compared are identifiers, lengths, SDO commands and objects, in order; not times, values, and what comes by the clock.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

import socketcan_test
from eds import Eds

REPOSITORY = socketcan_test.REPOSITORY
PAGE = REPOSITORY / "docs/can-sessions.md"
HERE = pathlib.Path(__file__).resolve().parent
TITLES = {"bring_up": ("1: bring-up", """A node on `vcan0` (`slipstack node --can vcan0 --node 5`, or the real controller). The frames to 605h, 000h, 205h and
305h were sent by `cansend`: device type, heartbeat every 100 ms, command time-out off (nobody types every 50 ms), operational,
mode 8 and the controlwords 6, 7, Fh by RPDO 1, a target by RPDO 2, taken at SYNC; then off again."""),
          "deploy": ("2: deploy a model", "`slipstack deploy axis.toml --can vcan0 --node 5`"),
          "record": ("3: record and diagnose", """Enabled in mode 1 by RPDO 1, then `slipstack record --can vcan0 --node 5 --seconds 12 --rate 500 --out log.csv`.
Meanwhile `cansend` moves the axis: small moves at several places, slow traverses, fast ones (no log can show what the axis did not do), each by
its velocity to 6081h and its target by RPDO 2 with bit 4 of the controlword down, then up; taken at the SYNC that the drive sends while it
records. Off again; `slipstack diagnose log.csv | head -2`: this node was started with `--effects viscous --strength 6`, so that there is something to find.
Then the trace (`slipstack record --trace --out trace.csv`) and `slipstack status --can vcan0 --node 5`.""")}
BY_THE_CLOCK = ("080", "185", "285", "385", "485")


def capture():
    with tempfile.TemporaryDirectory() as folder:
        model = socketcan_test.model_in(pathlib.Path(folder))
        done = subprocess.run([REPOSITORY / "toolchain/with-can", "bash", HERE / "documented_sessions.sh",
                               socketcan_test.SLIPSTACK, model], capture_output=True, text=True, timeout=570)
    if done.returncode == socketcan_test.SKIPPED:
        socketcan_test.skip(done.stdout.strip().removeprefix("SKIP: "))
    parts = re.split(r"^== ([\w ]+)\n", done.stdout, flags=re.M)
    return dict(zip(parts[1::2], parts[2::2]))


class Reader:
    """Distinguishes the frames of a session by their purpose."""

    def __init__(self):
        self.eds = Eds((REPOSITORY / "docs/slipstack.eds").read_text(encoding="ascii"))
        self.block = None
        self.acknowledged = False  # the last frame of a block upload was the master's

    def name(self, data):
        index, sub = int(data[4:6] + data[2:4], 16), int(data[6:8], 16)
        section = f"{index:04X}" if f"{index:04X}SUB0" not in self.eds.sections else f"{index:04X}sub{sub:X}"
        text = self.eds.sections.get(section.upper(), {}).get("PARAMETERNAME", "?")
        return f"{index:04X}h:{sub:02X} {text}"

    def kind(self, can_id, data):
        """(what it is: equal for frames of which one represents all, what to say about it)"""
        if can_id not in ("605", "585"):
            texts = {"705": {"00": "boot-up", "7F": "heartbeat: pre-operational", "05": "heartbeat: operational"},
                     "000": {"0105": "NMT: operational", "8005": "NMT: pre-operational"}}
            fixed = {"080": "SYNC", "205": "RPDO 1", "305": "RPDO 2", "185": "TPDO 1", "285": "TPDO 2", "385": "TPDO 3",
                     "485": "TPDO 4"}
            text = texts.get(can_id, {}).get(data) or fixed.get(can_id, "?")
            detail = data if can_id in ("000", "705", "205") else str(len(data))
            return f"{can_id} {detail}", text
        command = int(data[:2], 16)
        if can_id == "605" and self.block == "down":
            self.block = None if command & 0x80 else "down"
            return "block segment", "segment, 7 bytes"
        if can_id == "605" and self.block == "up":
            self.acknowledged = True
        if can_id == "585" and self.block == "up" and command & 0x7F:
            # A capture may lack segments of a burst. After an acknowledgement comes segment 1, or the end.
            if self.acknowledged and command & 0xE3 == 0xC1:
                self.block = None
                return "block end up", "end: bytes not used, checksum"
            self.acknowledged = False
            self.block = None if command & 0x80 else "up"
            return "block segment up", "segment, 7 bytes"
        words = {("605", 2): "upload", ("585", 2): "value of", ("605", 1): "download", ("585", 3): "taken:",
                 ("585", 4): "abort"}
        what = words.get((can_id, command >> 5))
        if what:
            return f"{can_id} {command & 0xE0:02X} {data[2:8]}", f"{what} {self.name(data)}"
        if can_id == "605" and command & 0xE3 in (0xC0, 0xC2):
            return f"block download {data[2:8]}", f"block download of {self.name(data)}"
        if can_id == "605" and command & 0xE3 == 0xA0:
            return f"block upload {data[2:8]}", f"block upload of {self.name(data)}"
        if can_id == "585" and command & 0xE3 == 0xA0:
            self.block = "down"
            return f"block goes {data[2:8]}", "go on, 127 segments in a block"
        if can_id == "605" and command == 0xA3:
            self.block = "up"
            return "block start", "start"
        if (can_id, command) == ("605", 0xA1):
            self.block = None
            return "block end taken", "end taken"
        if command & 0xE3 == 0xC1 and can_id == "585":
            return "block end up", "end: bytes not used, checksum"
        if command & 0xE3 == 0xC1:
            return "block end", "end: bytes not used, checksum"
        if command & 0xE3 == 0xC2:
            return f"block size {data[2:8]}", f"size of {self.name(data)}"
        texts = {("585", 0xA2): "block taken", ("605", 0xA2): "block taken", ("585", 0xA1): "all taken"}
        return f"{can_id} {command:02X}", texts.get((can_id, command), "?")


def lines_of(log):
    """Lines of a page: one for each kind of frame, dots for those that repeat a kind."""
    reader, seen, lines = Reader(), set(), []
    for can_id, data in re.findall(r" vcan0 ([0-9A-F]{3})#([0-9A-F]*)\n", log):
        kind, text = reader.kind(can_id, data)
        if kind in seen:
            if lines[-1] != "...":
                lines.append("...")
            continue
        seen.add(kind)
        spaced = " ".join(data[i:i + 2] for i in range(0, len(data), 2))
        lines.append(f"{can_id}   [{len(data) // 2}]  {spaced:24} ; {text}".rstrip())
    return lines


def page(said):
    text = ["# Three sessions on the bus", "",
            "Captured from the programs on a real CAN socket by `tests/can/sessions/documented_sessions.py --write`, which also checks that",
            "this page is not stale. One line for each kind of frame; `...` marks more of kinds already shown. What follows `;` is",
            "by the data sheet, [`slipstack.eds`](slipstack.eds). CAN in general: [can.md](can.md).", ""]
    for key, (title, words) in TITLES.items():
        text += [f"## Session {title}", "", words, "", "```", *lines_of(said[key]), "```", ""]
        if said[f"{key} said"].strip():
            text += ["The commands say", "", "```", said[f"{key} said"].strip(), "```", ""]
    return "\n".join(text).rstrip() + "\n"


def structure(text):
    """What must be the same: per session the frames that a master or its answers are, without values."""
    sessions = []
    for part in text.split("## Session ")[1:]:
        part = re.sub(r"^705 .*heartbeat.*\n", "", part, flags=re.M)
        frames = re.findall(r"^([0-9A-F]{3})   \[(\d)\]  ([0-9A-F ]*?) *; (.*)$", part, flags=re.M)
        sessions.append(([(can_id, length, words) for can_id, length, _, words in frames if can_id not in BY_THE_CLOCK],
                         {(can_id, length, words) for can_id, length, _, words in frames if can_id in BY_THE_CLOCK},
                         [line.split()[0] for line in part.split("The commands say")[-1].split("\n")
                          if re.match(r"^[a-zA-Z]+ {2,}\S", line)]))
    return sessions


def model_sizes(text):
    """Bytes of the model image in the frames that announce it: they follow from the catalogue of effects."""
    return re.findall(r"^\d{3}   \[8\]  C\d 41 21 00 ((?:[0-9A-F]{2} ){3}[0-9A-F]{2})", text, flags=re.M)


# Where a machine is so busy that it loses frames, a transfer is repeated in a way that no page shows, or the answers of
# the drive are missing in the capture. A page that is stale differs from every capture.
CAPTURES = 3


def fault_of(said, new):
    """What is wrong with the session itself, if anything."""
    if "?" in new.replace("type?", "") or "abort" in new.split("```")[1]:
        return "frames that nobody understands"
    # Where the machine is too busy, the record is over before the moves are (can_master_test has the same in the
    # drive's own time).
    if "Missing: Viscous friction." not in new and ("yes" in said["moves"] or sys.argv[1:]):
        return "the log of session 3 does not show the hidden effect"
    return ""


def main():
    kept = PAGE.read_text()
    for _ in range(CAPTURES):
        said = capture()
        new = page(said)
        stale = structure(new) != structure(kept)
        fault = fault_of(said, new)
        if not fault and (sys.argv[1:] or not stale):
            break
        print(f"{new}\nFAIL: {fault or 'docs/can-sessions.md has other frames'}", flush=True)
    else:
        if stale and not fault:
            print("docs/can-sessions.md is stale: run python3 tests/can/sessions/documented_sessions.py --write, and read it")
        return 1
    if sys.argv[1:] == ["--write"] or sys.argv[1:] == ["--update"] and (stale or model_sizes(new) != model_sizes(kept)):
        PAGE.write_text(new)
    return 0


if __name__ == "__main__":
    sys.exit(main())
