"""Decoders that do what damaged bytes could make one do, in the place of real ones."""

from pathlib import Path

import psutil

from storage.decoders import parquet_program
from storage.decoders.pool import DecoderPool
from storage.decoders.process import DecoderProgram
from tasks.ingest import laz_program

MEMORY_BYTES = 256 << 20

DEEDS = """
import importlib.util, os, signal, time

def segfault():
    os.kill(os.getpid(), signal.SIGSEGV)

def abort():
    os.abort()

def loop():
    while True:
        pass

def wait():
    time.sleep(3600)

def stop():
    os.kill(os.getpid(), signal.SIGSTOP)

def hunger():
    return len([bytearray(1 << 20) for _ in range(1 << 12)])

def leave():
    os._exit(0)

def be_killed():
    os.kill(os.getpid(), signal.SIGKILL)

def talk():
    os.write(1, b"noise of a library\\n")

class PanicException(BaseException):
    pass

def panic():
    raise PanicException("index out of bounds")

def lack_threads():
    raise PanicException("ThreadPoolBuildError: Resource temporarily unavailable")

def refuse():
    raise ValueError("not like this")

def be_refused():
    raise OSError(5, "Input/output error")

DEEDS = {deed.__name__: deed for deed in (
    segfault, abort, loop, wait, stop, hunger, leave, be_killed, talk, panic, lack_threads, refuse, be_refused)}
"""

ALONE = """
HANDLERS = {name: (lambda _memory, deed=deed: deed()) for name, deed in DEEDS.items()}
"""

IN_THE_PLACE_OF = """
spec = importlib.util.spec_from_file_location("real", {file!r})
real = importlib.util.module_from_spec(spec)
spec.loader.exec_module(real)
opened = []

def open_scan(memory, path, **given):
    opened[:] = [path]
    return real.HANDLERS["open"](memory, path, **given)

def decode(memory, **given):
    if "bad" in opened[0]:
        DEEDS[{deed!r}]()
    return real.HANDLERS["decode"](memory, **given)

HANDLERS = {{**real.HANDLERS, "open": open_scan, "decode": decode}}
"""

REAL = {".laz": laz_program.__file__, ".parquet": parquet_program.__file__}
PLACE = {".laz": "tasks.ingest.laz_decoder", ".parquet": "storage.decoders.parquet_points"}


def pool_of_deeds(folder: Path) -> DecoderPool:
    """Decoders whose requests are the deeds."""
    return _pool(folder / "deeds.py", DEEDS + ALONE)


def spoilt_pool(folder: Path, suffix: str, deed: str) -> DecoderPool:
    """Decoders of a format that do a deed when they decode a scan with "bad" in its path."""
    return _pool(folder / f"{deed}.py", DEEDS + IN_THE_PLACE_OF.format(file=REAL[suffix], deed=deed))


def _pool(file: Path, text: str) -> DecoderPool:
    file.write_text(text)
    return DecoderPool(DecoderProgram("spoilt", file, MEMORY_BYTES))


def children_with(word: str) -> list[psutil.Process]:
    """Children of this process that are at work and have a word in their command line.

    What other tests have started and nobody waited for may have ended, and has none.
    """
    return [child for child in psutil.Process().children() if word in str(_command_line(child))]


def _command_line(child: psutil.Process) -> list[str]:
    try:
        return child.cmdline()
    except (psutil.ZombieProcess, psutil.NoSuchProcess):
        return []
