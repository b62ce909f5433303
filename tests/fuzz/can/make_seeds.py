# SPDX-License-Identifier: Apache-2.0
"""Writes the seeds of the fuzzers: sessions as a master has them, to be mutated. Others in the folder stay: what a
fuzzer found, and those of client_fuzz that do not follow from the object dictionary.

    python3 tests/fuzz/can/make_seeds.py tests/fuzz/can/corpus      FOLDER/node, FOLDER/slcan, FOLDER/client
"""

import binascii
import pathlib
import struct
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "tests/can/description_files"))

from eds import Eds  # noqa: E402

IDS = {0x605: 0, 0x000: 3, 0x080: 4, 0x205: 5, 0x305: 6, 0x405: 7, 0x505: 8, 0x7E5: 9, 0x701: 10, 0x705: 11}
POLL = bytes([0xA3])        # 0.9 ms later
LONG = bytes([0xBF]) * 12   # 1.15 s
TICKS = bytes([0xDF])


def frame(can_id, data, flags=0):
    return bytes([IDS[can_id], len(data) | flags]) + data


def sdo(command, index=0, sub=0, data=b""):
    return frame(0x605, struct.pack("<BHB", command, index, sub) + data.ljust(4, b"\0")[:4]) + POLL


def raw(*data):
    return frame(0x605, bytes(data).ljust(8, b"\0"))


def write(index, sub, value, size):
    return sdo(0x23 | (4 - size) << 2, index, sub, value.to_bytes(4, "little"))


def real(index, sub, value):
    return sdo(0x23, index, sub, struct.pack("<f", value))


def nmt(command):
    return frame(0x000, bytes([command, 5])) + POLL


def lss(*data):
    return frame(0x7E5, bytes(data).ljust(8, b"\0")) + POLL


def image():
    """The model of a node as delivered, with a mass: every row of every effect but the first."""
    eds = Eds((REPOSITORY / "docs/slipstack.eds").read_text(encoding="ascii"))
    words = [(key, entry) for key, entry in sorted(eds.objects.items()) if 0x2100 <= key[0] < 0x2140 and key[1] > 0]
    packed = {(0x2100, 1): struct.pack("<I", 1), (0x2100, 2): struct.pack("<f", 12.5)}
    return b"".join(packed.get(key) or struct.pack("<f" if entry["type"] == 8 else "<I", entry["default"])
                    for key, entry in words)


def block_down(data, with_crc=True):
    """A block download of 2141h: begin, segments, end."""
    begin = sdo(0xC6 if with_crc else 0xC2, 0x2141, 0, len(data).to_bytes(4, "little"))
    parts = [data[i:i + 7] for i in range(0, len(data), 7)]
    segments = b"".join(raw(i | (0x80 if i == len(parts) else 0), *part) for i, part in enumerate(parts, 1))
    end = raw(0xC1 | (7 - len(parts[-1])) << 2, *binascii.crc_hqx(data, 0).to_bytes(2, "little"))
    return begin + segments + POLL * 5 + end + POLL


def program_image(size=90, damage=0):
    """An image for slot 2 of the host's board (firmware/update/image_header.h)."""
    program = bytes(range(size))
    head = struct.pack("<15I", 0x49504C53, 1, 0, 0x534C4B31, 0x54534F48, 1, 0x08047000, size,
                       binascii.crc32(program) ^ damage, *[0] * 6)
    return head + struct.pack("<I", binascii.crc32(head)) + program


def segmented_down(index, sub, data):
    parts = [data[i:i + 7] for i in range(0, len(data), 7)]
    segments = (raw(i % 2 << 4 | (7 - len(part)) << 1 | (i + 1 == len(parts)), *part) + POLL
                for i, part in enumerate(parts))
    return sdo(0x21, index, sub, len(data).to_bytes(4, "little")) + b"".join(segments)


CLEAR = write(0x1F51, 1, 3, 1) + POLL * 115
PROGRAM = program_image()

SAVE = sdo(0x23, 0x1010, 1, b"save")
ENABLE = write(0x6060, 0, 8, 1) + b"".join(write(0x6040, 0, word, 2) + bytes([0xC2]) for word in (6, 7, 15))
SEGMENTS = b"".join(raw(i % 80 + 1 | (0x80 if i == 79 else 0), 1, 2, 3, 4, 5, 6, 7) for i in range(80))

NODE = {
    "update": CLEAR + segmented_down(0x1F50, 1, PROGRAM) + sdo(0x40, 0x1F57, 1) + write(0x1F51, 1, 1, 1) + LONG,
    "update_damaged": CLEAR + segmented_down(0x1F50, 1, program_image(damage=1)) + write(0x1F51, 1, 1, 1) + LONG,
    "update_broken_off": CLEAR + sdo(0x21, 0x1F50, 1, b"\0\1") + raw(0, *PROGRAM[:7]) + POLL + LONG
                         + segmented_down(0x1F50, 1, PROGRAM) + sdo(0x40, 0x2410, 9),
    "too_long": frame(0x605, bytes(8), 0)[:1] + b"\x0F" + bytes(8) + POLL,
    "expedited": sdo(0x40, 0x1000) + sdo(0x40, 0x1018, 4) + write(0x1017, 0, 100, 2) + LONG + sdo(0x40, 0x1001),
    "segmented_up": sdo(0x40, 0x1008) + raw(0x60) + POLL + raw(0x70) + POLL + raw(0x60) + POLL,
    "segmented_down": sdo(0x21, 0x2000, 5, b"\4") + raw(0x07, 0, 0, 0x20, 0x42) + POLL + raw(0x13) + POLL,
    "unsized_down": sdo(0x20, 0x2000, 5) + b"".join(raw(i % 2 << 4, 1, 2, 3, 4, 5, 6, 7) + POLL for i in range(6))
                    + sdo(0x20, 0x2141) + b"".join(raw(i % 2 << 4, 1, 2, 3, 4, 5, 6, 7) + POLL for i in range(82)),
    "unsized_block": sdo(0xC2, 0x2141) + SEGMENTS.replace(b"\xd0\1\2", b"\x50\1\2") + SEGMENTS[:400] + POLL * 5,
    "mapping_too_long": write(0x1800, 1, 0xC0000185, 4) + write(0x1A00, 0, 0, 1)
                        + b"".join(write(0x1A00, i, 0x60640020, 4) for i in range(1, 9)) + write(0x1A00, 0, 8, 1)
                        + write(0x1A00, 0, 2, 1) + write(0x1800, 1, 0x40000185, 4) + nmt(1) + POLL * 3,
    "toggle_wrong": sdo(0x40, 0x1008) + raw(0x70) + POLL + sdo(0x21, 0x2000, 5, b"\4") + raw(0x17, 0, 0, 0x20) + POLL,
    "block_down": block_down(image()) + sdo(0x40, 0x2140, 1),
    "block_down_no_crc": block_down(image(), False),
    "block_down_wrong": block_down((bytes(range(1, 141)) * (len(image()) // 140 + 1))[:len(image())]),
    "block_up": sdo(0xA4, 0x2141, 0, b"\x0a") + raw(0xA3) + POLL * 4 + raw(0xA2, 10, 20) + POLL * 4 + raw(0xA2, 7, 20) + POLL,
    "master_dies": sdo(0xC6, 0x2141, 0, len(image()).to_bytes(4, "little")) + SEGMENTS[:40] + LONG + sdo(0x40, 0x1000),
    "trace": write(0x2300, 3, 1, 2) + write(0x2300, 4, 0, 1) + write(0x2300, 7, 20, 2) + write(0x2300, 1, 1, 1) + TICKS * 4
             + sdo(0xA4, 0x2310, 0, b"\x7f") + raw(0xA3) + POLL * 20 + raw(0xA2, 127, 127) + POLL * 20 + raw(0xA1) + POLL,
    "model_applied": real(0x2100, 2, 12.5) + sdo(0x40, 0x2140, 1) + write(0x2140, 3, 0x3032E61F, 4) + TICKS + POLL + SAVE + sdo(0x40, 0x2140, 2),
    "mapping": write(0x1800, 1, 0xC0000185, 4) + write(0x1A00, 0, 0, 1) + write(0x1A00, 1, 0x60640020, 4)
               + write(0x1A00, 0, 1, 1) + write(0x1800, 1, 0x40000185, 4) + nmt(1) + TICKS + POLL * 8,
    "pdo": nmt(1) + frame(0x205, b"\x06\0\x08") + POLL + frame(0x305, b"\x0f\0\0\1\0\0") + frame(0x080, b"") + POLL * 3
           + frame(0x205, b"\x06") + POLL + frame(0x405, bytes(8)) + frame(0x505, bytes(8)) + POLL,
    "csp": nmt(1) + ENABLE + b"".join(frame(0x305, b"\x0f\0" + struct.pack("<i", 100 * i)) + frame(0x080, b"") + POLL
                                      + bytes([0xCA]) for i in range(8)) + frame(0x205, b"\x0b\0\x08") + POLL + TICKS * 4,
    "profile": ENABLE.replace(b"\x60\x00\x08", b"\x60\x00\x01", 1) + write(0x607A, 0, 5000, 4) + write(0x6040, 0, 0x1F, 2)
               + TICKS * 8 + write(0x6040, 0, 0x11F, 2) + TICKS + write(0x6040, 0, 0, 2) + TICKS,
    "sync_producer": write(0x1019, 0, 5, 1) + write(0x1006, 0, 1000, 4) + write(0x1005, 0, 0x40000080, 4) + nmt(1) + POLL * 20,
    "heartbeat_consumer": sdo(0x23, 0x1016, 1, struct.pack("<I", 0x000100C8)) + frame(0x701, b"\5") + POLL + nmt(1) + LONG
                          + frame(0x701, b"\5") + POLL,
    "store_power_cut": real(0x2000, 5, 30.0) + b"\xE4\x20" + SAVE + b"\xE0" + sdo(0x40, 0x2000, 5) + SAVE + b"\xE0" + TICKS,
    "restore": write(0x1017, 0, 50, 2) + SAVE + sdo(0x23, 0x1011, 1, b"load") + nmt(129) + POLL,
    "lock": b"".join(write(0x2400, sub, sub * 0x01010101, 4) for sub in (6, 7, 8, 9)) + write(0x2400, 10, 1, 1)
            + sdo(0x40, 0x2400, 2) + sdo(0x40, 0x2400, 3) + write(0x2400, 4, 1, 4) + write(0x2400, 5, 2, 4) + SAVE + nmt(130),
    "lss": lss(4, 1) + lss(0x11, 6) + lss(0x13, 0, 2) + lss(0x15, 1, 0) + lss(0x17) + lss(0x5E) + lss(4, 0) + nmt(130) + POLL,
    "lss_select": lss(0x40) + lss(0x41, 0x31, 0x4B, 0x4C, 0x53) + lss(0x42, 0, 0, 1) + lss(0x43, 0x78, 0x56, 0x34, 0x12)
                  + lss(0x11, 255) + lss(0x17) + lss(4, 0) + b"\xE0" + lss(0x51, 0, 0, 0, 0, 0x80) + lss(0x51, 0, 0, 0, 0, 31),
    "bus_off": nmt(1) + b"\xE1" + LONG + POLL * 4 + b"\xE2" + TICKS + LONG + b"\xE3" + POLL,
    "remote_and_extended": frame(0x605, bytes(8), 0x20) + frame(0x705, b"\0", 0x20) + frame(0x205, b"\6\0\1", 0x10) + POLL,
}


def piece(text, room=3):
    return bytes([room << 6 | len(text)]) + text


SLCAN = {
    "frames": piece(b"t6058400010000000000\r") + piece(b"T123456788" + b"1122334455667788\r") + piece(b"r7050\rR000000014\r"),
    "commands": piece(b"O\rC\rO\rS6\rs031C\rV\rN\rF\r"),
    "pieces": piece(b"t60") + piece(b"58400010", 0) + piece(b"0000000000\rt0"),
    "refused": piece(b"t8008\rt6059\rX\r\rt60584\rT2000000080\r\n"),
    "long": piece(b"t" * 60) + piece(b"t" * 60) + piece(b"\rt0000\r"),
    "deaf": b"".join(piece(b"V\rt7ff0\r", 0) for _ in range(20)),
}


def client_deploys():
    """Answers of a node to `deploy`, as client_fuzz reads them: the model goes down, and comes up the same."""
    size = len(image())
    segments = -(-size // 7)
    blocks = [min(127, segments - at) for at in range(0, segments, 127)]
    begin = b"\x05\x04\x43\x31KLS\x04\x4b\x50\0\0\0\x04\x43\0\0\0\0\x04\xa4\x7f\0\0\0"
    taken = b"".join(bytes([0xF8, 1, 8, 0, 0, 0xA2, block, 0x7F, 0, 0, 0, 0, 0]) for block in blocks)
    up = b"\0\xa1\x04\xc6" + size.to_bytes(4, "little") + b"\xa0\x63" * (segments - 1) + b"\xa0\0"
    return begin + taken + up + bytes([0, 0xC1 | (7 * segments - size) << 2])


CLIENT = {"deploy": client_deploys()}


def main():
    for name, seeds in (("node", NODE), ("slcan", SLCAN), ("client", CLIENT)):
        folder = pathlib.Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        for seed, data in seeds.items():
            (folder / seed).write_bytes(data)


if __name__ == "__main__":
    main()
