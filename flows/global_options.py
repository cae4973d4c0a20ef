"""The options that every command has; they may stand anywhere before ``--``."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from flows.terminal import Terminal

VERBOSE: Final = re.compile(r"-v+|--verbose")

HELP: Final = """\
Everywhere: -v, --verbose: more; -vv: tracebacks; -q, --quiet: results and
errors only; --no-color (or the environment variable NO_COLOR).

Exit codes: 0 done, 1 fault of the program, 2 wrong usage,
3 bad campaign file or input, 4 quality gate not passed, 5 warning, 6 alarm
(4 to 6 from status, 5 and 6 from alarms, and from run with --fail-on),
130 interrupted.
"""


@dataclass(frozen=True, slots=True)
class CommandLine:
    """The words of a call, apart from the options that every command has."""

    terminal: Terminal
    words: tuple[str, ...]

    @property
    def wants_json(self) -> bool:
        """Whether a program reads the answer."""
        return "--json" in self.words


def split_command_line(argv: Sequence[str]) -> CommandLine:
    """Take the options that every command has out of the words of a call."""
    end = argv.index("--") if "--" in argv else len(argv)
    verbosity, quiet, color = 0, False, True
    words: list[str] = []
    for word in argv[:end]:
        if VERBOSE.fullmatch(word):
            verbosity += 1 if word == "--verbose" else len(word) - 1
        elif word in {"-q", "--quiet"}:
            quiet = True
        elif word == "--no-color":
            color = False
        else:
            words.append(word)
    return CommandLine(Terminal(verbosity, quiet, color), (*words, *argv[end:]))
