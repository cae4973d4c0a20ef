"""The child in which a decoder runs. It is started by its path and imports nothing of ours but its program.

Every request has a limit of computing and one of waiting, which the kernel keeps: the child ends also where native code
loops, where it waits for ever, and where its parent was killed meanwhile. Between requests it ends with its parent, whose
pipe closes then.
"""

import contextlib
import importlib.util
import json
import mmap
import os
import signal
import sys
from collections.abc import Iterator
from typing import Any, BinaryIO, Final

OUTPUT: Final = 1
MESSAGES: Final = 2


def main() -> None:
    """Answer the requests of the parent, a line each, until it is gone."""
    start = json.loads(sys.argv[1])
    sys.path[:] = start["import_from"]
    answers = _own_output()
    _set_signals()
    handlers = _handlers_of(start["program"])
    memory = _Memory(start["memory"])
    _bound_memory(start["memory_bytes"])
    # the parent is gone where it takes no answer
    with contextlib.suppress(BrokenPipeError):
        for line in sys.stdin.buffer:
            answers.write(json.dumps(_answer(handlers, memory, json.loads(line))).encode() + b"\n")
            answers.flush()
    # what a decoder does at its end is nobody's business any more
    os._exit(0)


class _Memory:
    """Memory that parent and child share: a file without a name, or on Windows a mapping with one."""

    def __init__(self, handle: int | str) -> None:
        self._handle = handle
        self._mapped: mmap.mmap | None = None

    def of(self, n_bytes: int) -> mmap.mmap | None:
        if n_bytes and (self._mapped is None or len(self._mapped) != n_bytes):
            self._mapped = _mapped(self._handle, n_bytes)
        return self._mapped


def _mapped(handle: int | str, n_bytes: int) -> mmap.mmap:
    if sys.platform == "win32":
        return mmap.mmap(-1, n_bytes, tagname=f"{handle}-{n_bytes}")
    return mmap.mmap(int(handle), n_bytes)


def _answer(handlers: dict[str, Any], memory: _Memory, request: dict[str, Any]) -> dict[str, Any]:
    try:
        with _limited(request["computing_s"], request["waiting_s"]):
            return {"value": handlers[request["do"]](memory.of(request["memory_bytes"]), **request["given"])}
    # a panic of a decoder written in Rust derives from BaseException
    except BaseException as fault:
        number = fault.errno if isinstance(fault, OSError) else None
        kind = "MemoryError" if isinstance(fault, MemoryError) else type(fault).__name__
        return {"fault": kind, "errno": number, "text": _text(fault)}


def _text(fault: BaseException) -> str:
    said = fault.strerror if isinstance(fault, OSError) and fault.strerror else str(fault)
    return said[:1000]


@contextlib.contextmanager
def _limited(computing_s: float, waiting_s: float) -> Iterator[None]:
    """End this process by a signal where it computes or takes longer."""
    if sys.platform == "win32":
        yield
        return
    signal.setitimer(signal.ITIMER_PROF, computing_s)
    signal.setitimer(signal.ITIMER_REAL, waiting_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _own_output() -> BinaryIO:
    """Where answers go; what the decoder prints goes nowhere, or it would stand between them."""
    answers = os.fdopen(os.dup(OUTPUT), "wb")
    os.dup2(MESSAGES, OUTPUT)
    return answers


def _set_signals() -> None:
    # an interrupt at the keyboard is the parent's: it ends this one
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        limits = {signal.SIGPROF, signal.SIGALRM}
        for number in limits:
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, limits)


def _bound_memory(n_bytes: int) -> None:
    """Bound what this process may allocate, and leave no image of it behind where it crashes."""
    if sys.platform != "win32":
        import resource  # noqa: PLC0415 - not there on Windows

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        # on Linux what is written to and not shared counts, neither what is reserved nor mapped files
        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        bound = n_bytes if most == resource.RLIM_INFINITY else min(n_bytes, most)
        resource.setrlimit(resource.RLIMIT_DATA, (bound, bound))


def _handlers_of(file: str) -> dict[str, Any]:
    spec = importlib.util.spec_from_file_location("program", file)
    if spec is None or spec.loader is None:
        raise ImportError(file)
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    return {"hello": _hello, **program.HANDLERS}


def _hello(_memory: mmap.mmap | None) -> None:
    """Only show that this process answers."""


if __name__ == "__main__":
    main()
