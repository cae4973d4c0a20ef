"""``tiltwatch dashboard``: the results in a browser."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

import os
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import note, say
from storage.errors import InputError

TOKEN_VARIABLE = "TILTWATCH_DASHBOARD_TOKEN"  # noqa: S105 (its name)


def dashboard(
    file: CampaignFile,
    /,
    *,
    port: int = 8050,
    host: str = "127.0.0.1",
    token_file: Path | None = None,
    open_browser: Annotated[bool, Parameter(name="--open", negative="")] = False,
    workspace: WorkspaceFolder = None,
) -> int:
    """Show the results in a browser, and follow new epochs while runs write them; nothing leaves this machine.

    Parameters
    ----------
    port
        Port to listen on; 0 has a free one chosen.
    host
        Address to listen on. Any but this machine's own needs a token.
    token_file
        File of mode 600 with the token that visitors need; else the environment variable TILTWATCH_DASHBOARD_TOKEN.
    open_browser
        Open the page in the browser of this desktop.
    """
    from dashboard.server import Listening, serve
    from dashboard.view import Site
    from flows.rule_words import rule_words
    from storage.workspace import open_workspace

    campaign = load_with_workspace(file, workspace)
    place = open_workspace(workspace_of(campaign.folder, workspace))
    name = campaign.structure.name or campaign.structure.id
    primary = (campaign.report.primary[0], campaign.report.primary[1])
    sites = {campaign.structure.id: Site(name, primary, file.name, rule_words(campaign))}
    where = Listening(host, port, _token(token_file))

    def ready(address: str) -> None:
        note(f"results of {place.root}; end with Ctrl+C")
        say(address)
        if open_browser:
            import webbrowser

            webbrowser.open(address)

    serve(place, sites, where, ready)
    return 0


def _token(file: Path | None) -> str | None:
    if file is None:
        return os.environ.get(TOKEN_VARIABLE) or None
    try:
        mode = file.stat().st_mode
        text = file.read_text().strip()
    except (OSError, UnicodeDecodeError) as fault:
        raise InputError(
            f"token file {file} cannot be read ({fault}); write the token into it, in a line"
        ) from fault
    if os.name == "posix" and mode & 0o077:
        raise InputError(f"token file {file} can be read by others; `chmod 600 {file}` keeps it to you")
    if not text:
        raise InputError(f"token file {file} is empty; write the token into it, in a line")
    return text
