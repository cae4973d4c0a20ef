"""The commands, by name; each is loaded when it is called and not before."""

from collections.abc import Mapping
from typing import Final

from cyclopts import App

from flows.global_options import HELP
from flows.version import VERSION

COMMANDS: Final[Mapping[str, str]] = {
    "demo": "Simulate a campaign with known truth, run everything on it, print found against true.",
    "init": "Write a commented example of a campaign file; an existing file is never overwritten.",
    "check": "Check a campaign file and the headers of its scans; no points are read.",
    "schema": "Print the JSON Schema of the campaign file, for editors and programs.",
    "plan": "Predict the sigma of the lean, the change that will be detectable and the coverage of a survey to come.",
    "limits": "List the tables of limits with their papers, and what they allow at a height.",
    "run": "Process what is not processed yet, and print Tables 1 to 3 of the paper for the newest epoch.",
    "reprocess": "Process epochs again with a new method or version, keep the old results, print what changed.",
    "status": "Print the newest state; the exit code tells quality, warning and alarm.",
    "alarms": "List the alarms, the active ones first; --evaluate looks for new ones and delivers them.",
    "acknowledge": "Say that somebody has seen an alarm.",
    "mute": "Keep an alarm quiet for a while, or for good.",
    "unmute": "Let a muted alarm speak again.",
    "close": "End an alarm; its rule raises a new one at the next epoch if need be.",
    "watch": "Take station files in as they arrive, say what is missing while the crew is on site, run complete epochs.",
    "compare": "Say for every scheme and method how far the top moved between two epochs, and what else changed.",
    "compare-schemes": "Compare schemes, methods and reference measurements of an epoch, and recommend how many slices "
    "are enough.",
    "dashboard": "Show the results in a browser, and follow new epochs while runs write them.",
    "export": "Write a view of the catalog, the geometry of an epoch, or the whole record to a file; to stdout where none "
    "is named.",
    "restore": "Bring back what export archive wrote: campaign file and workspace, verified, in a new folder.",
    "figures": "Draw figures 3 to 6 of the paper: stations and clouds, shaft, contours and axes of the schemes.",
    "report": "Write the report of an epoch as PDF/A and as one web page, in English or Chinese.",
    "deploy": "Put campaigns on the schedule of a workflow server: one deployment a structure, named by its id.",
    "recover": "Settle runs that were killed: what they did goes into the ledger, no server takes them for running any "
    "more.",
    "verify": "Check that everything in the workspace is whole and true to its digest.",
    "doctor": "Say whether this machine has what a run needs, and what to do where something lacks.",
}
"""Name of a command, which with _ for - is also its module in flows.commands and its function there; what it does."""


def application(called: str | None = None) -> App:
    """Make the command line.

    Parameters
    ----------
    called
        Name of the command that is called; its help is then the whole docstring, which only loading it can tell.
    """
    made = App(
        name="tiltwatch",
        help="Lean of tall structures from LiDAR scans: a vector with an uncertainty, epoch after epoch.",
        help_epilogue=HELP,
        help_format="plaintext",
        version=VERSION,
        help_flags=("--help", "-h"),
        version_flags=("--version",),
        suppress_keyboard_interrupt=False,
    )
    for order, (name, does) in enumerate(COMMANDS.items()):
        module = name.replace("-", "_")
        made.command(
            f"flows.commands.{module}:{module}",
            name=name,
            help=None if name == called else does,
            sort_key=order,
            help_format="plaintext",
        )
    return made
