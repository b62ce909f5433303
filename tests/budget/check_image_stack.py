#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Deepest stack of a whole firmware image: main, and every interrupt that may come on top of it.

  check_image_stack.py --build BUILD --budget stack.csv --linker-scripts DIR [--update] [--paths]

From the compiler's call graphs (-fcallgraph-info=su) of all sources of the image. The deepest path of the thread, then
one of each interrupt level, each with the frame that the processor pushes: 26 words with the FPU's registers, which
lazy stacking reserves whether it fills them or not (Armv7-M Architecture Reference Manual, B1.5.6 and B1.5.7), and 4
bytes of alignment. Refuses recursion, frames of unknown size, functions whose stack nobody knows, and calls through a
pointer but for those listed here with what they may reach. The sum must fit into what the linker script reserves, the
tick's into 2 KiB, and each figure must be that of the budget within its tolerance, on both sides.
"""

import argparse
import pathlib
import re
import subprocess
import sys

import budget_file
import check_stack
import emulator

TICK_LIMIT = 2048
HAL = {"mps2": ["startup", "semihosting", "uart"], "stm32g474": ["startup", "board"]}
# image: (folder of hal, object library, levels from the bottom up, the source of main)
MAIN, BOOT_MAIN = "main", "boot_main"
IMAGES = {
    "slipstack-mps2-an386": ("mps2", "slipstack_hal_mps2_an386", ["start_program", "fault_handler"], MAIN),
    "slipstack-mps2-an500": ("mps2", "slipstack_hal_mps2_an500", ["start_program", "fault_handler"], MAIN),
    # hal/stm32g474/board.h: LED 15, CAN and encoder 4, of which one runs at a time, tick 0; the NMI and a fault come through everything.
    "slipstack-stm32g474": (
        "stm32g474", "slipstack_hal_stm32g474",
        ["start_program", "indicator_handler", ("can_handler", "encoder_handler"), "tick_handler", "nmi_handler", "fault_handler"], MAIN,
    ),
    # No interrupts: the NMI of a bad word in flash, and a fault.
    "slipstack-stm32g474-boot": (
        "stm32g474", "slipstack_hal_stm32g474", ["start_program", "nmi_handler", "fault_handler"], BOOT_MAIN,
    ),
}  # fmt: skip

# Interfaces that are called through a pointer, and what stands behind each in an image: by symbol.
FLASH = r"_ZNK?9slipstack.*\d(MemoryFlash|FlashPages)"
INTERFACES = {
    "ObjectAccess": r"_ZNK?9slipstack7canopen11NodeObjects(4read|10check_read|5check|7written|6commit|4tick|12begin_upload|6upload|14begin_download|8download|12end_download)E",
    "Application": r"_ZNK?9slipstack7canopen5Drive\w+E",
    "CanPort": r"_ZNK?9slipstack(4mps29SlcanPort|9stm32g4743Can).*(4send|7receive|6status|7recover|\d+\w*bit_rate)E",
    "Nonvolatile": FLASH + r".*(10page_count|9page_size|10write_unit|5erase|4read|5write)E",
    "Indicator": r"_ZN9slipstack.*4showENS_10IndicationE",
    "constructors": r"_GLOBAL__sub_I_",
    "wait": r"_ZN9slipstack9stm32g4744Part7wait_us",
    "ProgramMemory": r"_ZNK?9slipstack9stm32g47412ProgramFlash.*(7running|5board|7address|7program|5spare|5notes|7restart)E",
    "AbsoluteEncoder": r"_ZNK?9slipstack.*AxisEncoder.*(3use|8counters)E",
    "AnalogueInputs": r"_ZNK?9slipstack.*(SlowInputs|LinkAnalogueInputs).*(11temperature|11bus_voltage|15has_temperature|15has_bus_voltage)E",
    "EdgeCapture": r"_ZNK?9slipstack.*(CapturedInput|LinkEdgeCapture).*(8terminal|4take)E",
    "SignalScaling": r"_ZNK?9slipstack.*Scaling(10set_scales|9largest_A)E",
}
# A board may have none of them: the pointer is then null.
OPTIONAL = {"SignalScaling", "ProgramMemory", "AbsoluteEncoder", "AnalogueInputs", "EdgeCapture"}
# The boot loader has no node and no static objects.
NOT_IN_BOOT = {"constructors", "CanPort", "Indicator", "Application"}
# Who may call which of them; the first that fits holds.
CALLERS = [
    (r"canopen::(Pdos|PdoMap|SdoServer|SdoAccess|Dictionary)::", ["ObjectAccess"]),
    (r"RecordSlots::|ParameterSet::", ["Nonvolatile"]),
    (r"slipstack::update::|canopen::ProgramDownload::", ["ProgramMemory", "Nonvolatile"]),
    (r"canopen::TouchProbeProfile::", ["EdgeCapture"]),
    (r"canopen::(ModelStaging|Drive|EncoderObjects|AnalogueObjects)::", ["SignalScaling", "AbsoluteEncoder", "AnalogueInputs", "ProgramMemory", "Nonvolatile"]),
    (r"canopen::(Node|NodeObjects|NodeParts|BusWatch|BitRateSwitch|Lss|Outbox)::|CanopenNode::", ["Application", "CanPort", "Nonvolatile"]),
    (r"start_clock_tree", ["wait"]),
    (r"start_program", ["constructors"]),
    (r"int main\(\)|Application<", ["CanPort", "Nonvolatile", "Indicator", "Application"]),
]
# Of libgcc and newlib (Debian 12: gcc-arm-none-eabi 12.2.rel1, newlib 3.3): frames read from their disassembly, with
# those of what they call, rounded up.
LIBRARY = {
    "memcpy": 32, "memmove": 32, "memset": 32, "memcmp": 32, "strlen": 16, "strchr": 32, "strcmp": 16, "__aeabi_memcpy": 32,
    "__aeabi_uldivmod": 96, "__aeabi_ldivmod": 96, "__aeabi_atexit": 0,
    "__aeabi_dadd": 16, "__aeabi_dsub": 16, "__aeabi_drsub": 16, "__aeabi_dmul": 24, "__aeabi_ddiv": 24, "__aeabi_f2d": 16,
    "__aeabi_d2f": 16, "__aeabi_i2d": 16, "__aeabi_l2d": 24, "__aeabi_ul2d": 24, "__aeabi_d2lz": 96, "__aeabi_d2ulz": 64,
    "__aeabi_dcmplt": 32, "__aeabi_dcmple": 32, "__aeabi_dcmpgt": 32, "__aeabi_dcmpge": 32, "__aeabi_dcmpeq": 32,
    "__aeabi_dcmpun": 16, "__aeabi_d2iz": 16, "__aeabi_f2lz": 64, "__aeabi_l2f": 16,
}  # fmt: skip


def fail(reason):
    print(f"FAIL: {reason}")
    sys.exit(1)


def plain(title):
    """The symbol without its file, of a constructor or destructor the one that holds the code."""
    symbol = title.split(":")[-1]
    return re.sub(r"(C|D)1(E)", r"\g<1>2\2", symbol)


class Graph:
    def __init__(self, files, optional):
        self.optional = optional
        self.frames, self.labels, self.calls = check_stack.read(files)
        self.by_symbol = {plain(t): t for t in self.frames}
        self.known = {}
        self.indirect = set()

    def resolve(self, title):
        return title if title in self.frames else self.by_symbol.get(plain(title), title)

    def behind(self, caller):
        """What a call through a pointer from here may reach."""
        for who, interfaces in CALLERS:
            if re.search(who, caller):
                found = []
                for interface in interfaces:
                    behind = [t for t in self.frames if re.match(INTERFACES[interface], plain(t))]
                    if not behind and interface not in self.optional:
                        fail(f"{caller} calls {interface}, and nothing stands behind it")
                    found += behind
                self.indirect.add((caller.split("(")[0].split(" ")[-1], " ".join(interfaces)))
                return found
        fail(f"{caller} calls through a pointer and is not listed")

    def deepest(self, title, path=()):
        """(bytes, path) of the deepest way down."""
        title = self.resolve(title)
        if title in path:
            fail("recursion: " + " -> ".join(self.labels.get(t, t) for t in [*path, title]))
        if title in self.known:
            return self.known[title]
        if title not in self.frames:
            if title in LIBRARY:
                return LIBRARY[title], [title]
            fail(f"{self.labels.get(path[-1], path[-1]) if path else 'the image'} calls {title}, whose stack nobody knows")
        below = []
        for called in self.calls.get(title, ()):
            targets = self.behind(self.labels[title]) if called == "__indirect_call" else [called]
            below += [self.deepest(t, (*path, title)) for t in targets]
        size, way = max(below, default=(0, []))
        self.known[title] = (self.frames[title] + size, [title, *way])
        return self.known[title]

    def level(self, name):
        roots = [t for t in self.frames if plain(t) == name]
        if not roots:
            fail(f"no function {name}")
        # A weak one in the start-up and the one that replaces it: the deeper counts.
        return max(self.deepest(t) for t in roots)


def reserved(image, script_folder):
    """What the linker script asserts for the stack, and what the image really leaves, bytes."""
    name = "stm32g474_sections.ld" if "stm32" in image.name else "mps2.ld"
    text = (script_folder / name).read_text()
    promise = re.search(r"ASSERT\(__stack_top - __bss_end >= (\d+)K", text)
    listing = subprocess.run(["arm-none-eabi-nm", image], capture_output=True, text=True, check=True).stdout
    at = {w[2]: int(w[0], 16) for w in (line.split() for line in listing.splitlines()) if len(w) == 3}
    return int(promise.group(1)) * 1024, at["__stack_top"] - at["__bss_end"]


def sources(main_source):
    """What of the firmware an image compiles."""
    parts = ["control/controller", "canopen/node", "canopen/drive"] if main_source == MAIN else []
    return [f"app/{main_source}", *parts]


def measure(build, image, show):
    folder, library, levels, main_source = IMAGES[image]
    base = build / "hal" / folder / "CMakeFiles"
    files = [base / f"{image}.dir/__/__/firmware/{source}.cpp.ci" for source in sources(main_source)]
    files += [base / f"{library}.dir/{name}.cpp.ci" for name in HAL[folder]]
    for file in files:
        if not file.is_file():
            fail(f"{file} is missing: build the cortex-m4 preset")
    graph = Graph(files, OPTIONAL | (NOT_IN_BOOT if main_source == BOOT_MAIN else set()))
    rows, total = {}, 0
    for number, level in enumerate(levels):
        names = level if isinstance(level, tuple) else (level,)
        for name in names:
            size, path = graph.level(name)
            rows[name] = size + (check_stack.EXCEPTION_FRAME if number > 0 else 0)
            if show:
                for title in path:
                    print(f"    {graph.labels.get(title, title)[:100]:<102}{graph.frames.get(title, LIBRARY.get(title, 0)):>6}")
        total += max(rows[name] for name in names)
    if "tick_handler" not in rows and main_source == MAIN:  # called by the main loop: part of the thread
        rows["tick_handler"] = graph.level("tick_handler")[0] + check_stack.EXCEPTION_FRAME
    rows["sum"] = total
    return rows, graph


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, type=pathlib.Path)
    parser.add_argument("--budget", required=True, type=pathlib.Path)
    parser.add_argument("--linker-scripts", required=True, type=pathlib.Path)
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--paths", action="store_true", help="print the deepest path of each level")
    options = parser.parse_args()
    emulator.require_tool("arm-none-eabi-nm")
    comments, rows_before = budget_file.read(options.budget)
    budget = {(row["image"], row["level"]): row for row in rows_before}
    made, failed = [], False
    print(f"{'stack, bytes':<26}{'level':<18}{'is':>6}{'budget':>8}{'limit':>7}")
    for image in IMAGES:
        elf = options.build / "bin" / f"{image}.elf"
        emulator.require(elf)
        rows, graph = measure(options.build, image, options.paths)
        promise, room = reserved(elf, options.linker_scripts)
        limits = {"tick_handler": TICK_LIMIT, "sum": min(promise, room)}
        for level, size in rows.items():
            row = budget.pop((image, level), None)
            faults = [] if row or options.update else ["no budget"]
            row = row or {"image": image, "level": level, "bytes": size, "tolerance": 64}
            if abs(size - int(row["bytes"])) > int(row["tolerance"]) and not options.update:
                faults.append("rose" if size > int(row["bytes"]) else "fell")
            if size > limits.get(level, size):
                faults.append("over the limit")
            print(f"{image:<26}{level:<18}{size:>6}{row['bytes']:>8}{limits.get(level, '-'):>7}  {', '.join(faults)}".rstrip())
            failed |= bool(faults)
            made.append({**row, "bytes": size})
        print(f"{image:<26}{len(graph.frames)} functions; the linker script reserves {promise}, the image leaves {room}")
        for who, what in sorted(graph.indirect):
            if options.paths:
                print(f"    {who} calls through {what}")
    for image, level in budget:
        print(f"{image:<26}{level:<18} not measured")
        failed = True
    if options.update:
        budget_file.write(options.budget, comments, ["image", "level", "bytes", "tolerance"], made)
        return 0
    if failed:
        print(f"FAIL: see the right-hand column; the budget is {options.budget}, paths by --paths")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
