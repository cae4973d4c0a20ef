"""``tiltwatch dashboard``: the results in a browser."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import note, say
from storage.secrets import secret_in, secret_of

if TYPE_CHECKING:
    from dashboard.view import Site

TOKEN_VARIABLE = "TILTWATCH_DASHBOARD_TOKEN"  # noqa: S105 (its name)


def dashboard(
    file: CampaignFile,
    /,
    *others: Annotated[Path, Parameter(help="campaign files of other structures of the same workspace")],
    port: int = 8050,
    host: str = "127.0.0.1",
    token_file: Path | None = None,
    open_browser: Annotated[bool, Parameter(name="--open", negative="")] = False,
    workspace: WorkspaceFolder = None,
) -> int:
    """Show the results in a browser, and follow new epochs while runs write them.

    Nothing leaves this machine. All structures of the workspace are shown; those whose campaign files are named have their
    names, rules of alarms and reports, too.

    Parameters
    ----------
    port
        Port to listen on; 0 has a free one chosen.
    host
        Address to listen on. Any but this machine's own needs a token.
    token_file
        File of mode 600 with the token that visitors need; else the environment variable TILTWATCH_DASHBOARD_TOKEN, or
        the file that TILTWATCH_DASHBOARD_TOKEN_FILE names.
    open_browser
        Open the page in the browser of this desktop.
    """
    from dashboard.server import Listening, serve
    from storage.upgrade import ready_or_new_workspace

    campaign = load_with_workspace(file, workspace)
    place = ready_or_new_workspace(workspace_of(campaign.folder, workspace))
    sites = {}
    for each in (file, *others):
        structure, site = _site(each, place.root)
        sites[structure] = site
    where = Listening(host, port, _token(token_file))

    def ready(address: str) -> None:
        note(f"results of {place.root}; end with Ctrl+C")
        say(address)
        if open_browser:
            import webbrowser

            webbrowser.open(address)

    serve(place, sites, where, ready)
    return 0


def _site(file: Path, workspace: Path) -> "tuple[str, Site]":
    """What the pages know of a structure by its campaign file."""
    from dashboard.view import Site
    from flows.rule_words import rule_words

    campaign = load_with_workspace(file, workspace)
    primary = (campaign.report.primary[0], campaign.report.primary[1])

    def report(epoch: str, kind: str, language: str) -> bytes:
        from dashboard.report.page import html_of
        from dashboard.report.paper import pdf_of
        from flows.commands.report import reported

        _facts, document = reported(campaign, workspace, epoch, language)
        return pdf_of(document) if kind == "pdf" else html_of(document).encode()

    site = Site(campaign.structure.title, primary, file.name, rule_words(campaign), report)
    return campaign.structure.id, site


def _token(file: Path | None) -> str | None:
    return secret_in(TOKEN_VARIABLE) if file is None else secret_of(file, "--token-file")
