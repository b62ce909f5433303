# SPDX-License-Identifier: Apache-2.0
"""Runs an image in the emulator; used by the checks beside it."""

import pathlib
import shutil
import subprocess
import sys

SKIP = 77  # ctest's SKIP_RETURN_CODE
QEMU = "qemu-system-arm"
TIMEOUT_S = 300


def skip(reason):
    print(f"SKIP: {reason}")
    sys.exit(SKIP)


def fail(reason):
    print(f"FAIL: {reason}")
    sys.exit(1)


def require(image):
    """Ends with SKIP unless the emulator and the image are there."""
    if shutil.which(QEMU) is None:
        skip(f"{QEMU} is not installed (package qemu-system-arm)")
    if not pathlib.Path(image).is_file():
        if shutil.which("arm-none-eabi-g++") is None:
            skip("arm-none-eabi-g++ is not installed (packages gcc-arm-none-eabi, libstdc++-arm-none-eabi-newlib)")
        fail(f"{image} is missing: cmake --preset cortex-m4 && cmake --build --preset cortex-m4")


def start(image, arguments=()):
    """The finished process of the emulator; ends with FAIL if the image does not end."""
    semihosting = ["enable=on", "target=native", "arg=image", *(f"arg={a}" for a in arguments)]
    command = [
        QEMU, "-M", "mps2-an386", "-icount", "shift=10", "-display", "none", "-monitor", "none",
        "-serial", "stdio", "-semihosting-config", ",".join(semihosting), "-kernel", str(image),
    ]  # fmt: skip
    try:
        return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        fail(f"{image} did not end within {TIMEOUT_S} s")


def run(image, arguments=()):
    """Output lines of the image, run to its end; ends with FAIL if its status is not 0."""
    done = start(image, arguments)
    if done.returncode != 0:
        print(done.stdout[-2000:] + done.stderr[-2000:])
        fail(f"{image} ended with status {done.returncode}")
    return done.stdout.splitlines()
