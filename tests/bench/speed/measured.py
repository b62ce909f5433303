# SPDX-License-Identifier: Apache-2.0
"""What a command costs."""

import os
import subprocess
import time


def measured(command):
    """Seconds, processor seconds and peak MB of a command that must succeed."""
    start = time.monotonic()
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        child = subprocess.Popen(command, stdout=nowhere, stderr=nowhere)
        _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise RuntimeError(f"{command} ended with {status}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0
