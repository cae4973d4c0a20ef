"""The entry point of the command line: words in, exit code out; no traceback for what is the user's to mend."""
# ruff: noqa: PLC0415 (imports stand where they are needed: a start must be quick)

import sys
from collections.abc import Sequence

from flows.version import VERSION
from storage.errors import TiltwatchError

INTERRUPTED = 130
FAULT = 1
WRONG_USAGE = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    ``--version`` is answered before anything else is imported.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if words in (["--version"], ["-V"]):
        print(f"tiltwatch {VERSION}")
        return 0
    code = _run(words)
    if argv is None:
        _hush_exit()
    return code


def _hush_exit() -> None:
    from flows.terminal import hush_exit

    hush_exit()


def _run(words: list[str]) -> int:
    from flows.global_options import split_command_line
    from flows.terminal import forget_stdout, survive_any_text, use_terminal

    for stream in (sys.stdout, sys.stderr):
        survive_any_text(stream)
    call = split_command_line(words)
    use_terminal(call.terminal)
    try:
        code = _dispatch(call.words, wants_json=call.wants_json)
        sys.stdout.flush()
    except BrokenPipeError:
        forget_stdout()
        return 0
    return code


def _dispatch(words: Sequence[str], *, wants_json: bool) -> int:
    from cyclopts import CycloptsError

    from flows.application import COMMANDS, application
    from flows.faults import report_error, report_fault

    called = words[0] if words and words[0] in COMMANDS else None
    try:
        code = application(called)(
            words, exit_on_error=False, print_error=False, result_action="return_value"
        )
    except CycloptsError as error:
        hint = f"`tiltwatch {f'{called} ' if called else ''}--help` shows what there is"
        return report_error(f"{str(error).strip()} {hint}", WRONG_USAGE, wants_json=wants_json)
    except TiltwatchError as error:
        if error.exit_code == FAULT:
            return report_fault(error, wants_json=wants_json)
        return report_error(str(error), error.exit_code, wants_json=wants_json)
    except KeyboardInterrupt:
        return report_error("interrupted; what was finished is kept", INTERRUPTED, wants_json=wants_json)
    except BrokenPipeError:
        raise
    except Exception as error:
        return report_fault(error, wants_json=wants_json)
    return code if isinstance(code, int) else 0


if __name__ == "__main__":
    sys.exit(main())
