"""Who writes a temp: its name tells the process, so that what a killed one left is swept by the next run.

A process is known by its id and by the machine, or container, in which that id is its own. Of a process elsewhere nobody
can tell whether it lives.
"""

import hashlib
import os
import re
import socket
from functools import cache
from pathlib import Path


def mark_of_this_process() -> str:
    """What stands in the names of temps of this process."""
    return f"{_home_of_ids()}-{os.getpid()}"


def is_writer_gone(temp: Path) -> bool:
    """Whether the process that wrote a temp has ended for certain; False where it cannot be told."""
    told = re.search(r"\.([0-9a-f]{8})-(\d+)\.[0-9a-f]{32}\.tmp$", temp.name)
    # elsewhere than on POSIX to ask for a process by its id may end it
    if told is None or os.name != "posix" or told[1] != _home_of_ids():
        return False
    try:
        os.kill(int(told[2]), 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return False


@cache
def _home_of_ids() -> str:
    """What tells the ids of processes here from those of another machine or container."""
    try:
        space = str(Path("/proc/self/ns/pid").readlink())
    except OSError:  # macOS and Windows have one for the whole machine
        space = ""
    try:
        machine = Path("/etc/machine-id").read_text(
            encoding="ascii"
        )  # machines of one name may share a drive
    except (OSError, ValueError):
        machine = ""
    return hashlib.sha256(f"{socket.gethostname()} {machine} {space}".encode()).hexdigest()[:8]
