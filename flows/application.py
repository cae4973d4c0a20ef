"""The commands, by name; each is loaded when it is called and not before."""

from typing import Final

from cyclopts import App

from flows.global_options import HELP
from flows.version import VERSION

COMMANDS: Final = (
    ("demo", "Simulate a campaign with known truth, run everything on it, print found against true."),
    ("init", "Write a commented example of a campaign file."),
    ("check", "Check a campaign file and the headers of its scans, without reading points."),
    ("schema", "Print the JSON Schema of the campaign file."),
    ("run", "Process what is not processed yet."),
    ("status", "Print the newest state; the exit code tells quality, warning and alarm."),
    ("compare", "Is the difference between two epochs significant?"),
    ("export", "Write a table of the workspace to a file."),
    ("verify", "Is everything stored whole and true to its digest?"),
    ("doctor", "Is this machine fit?"),
)
"""Name of the command, which is also its module and function in flows.commands, and what it does."""


def _application() -> App:
    app = App(
        name="tiltwatch",
        help="Lean of tall structures from LiDAR scans: a vector with an uncertainty, epoch after epoch.",
        help_epilogue=HELP,
        help_format="plaintext",
        version=VERSION,
        help_flags=("--help", "-h"),
        version_flags=("--version",),
    )
    for order, (name, does) in enumerate(COMMANDS):
        app.command(
            f"flows.commands.{name}:{name}", name=name, help=does, sort_key=order, help_format="plaintext"
        )
    return app


app: Final = _application()
"""The command line."""
