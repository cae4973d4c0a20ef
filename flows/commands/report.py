"""``tiltwatch report``: what an epoch found, for those who own, survey and sign."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, note
from storage.errors import StorageError, UsageError

if TYPE_CHECKING:
    from dashboard.report.blocks import Document
    from dashboard.report.facts import Facts, Origin
    from dashboard.report.settings import Settings
    from storage.records import EpochRow
    from storage.workspace import Workspace
    from tasks.settings import Campaign


def report(  # noqa: PLR0913 (options of a command)
    file: CampaignFile,
    /,
    *,
    epoch: str | None = None,
    pdf: Annotated[Path | None, Parameter(name="--pdf")] = None,
    html: Annotated[Path | None, Parameter(name="--html")] = None,
    lang: str = "en",
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Write the report of an epoch as PDF/A and as one web page, in English or Chinese.

    It holds verdict, method, course over time, shape, schemes, quality, and an annex of every number to sign.

    Where neither --pdf nor --html is given both are written beside the campaign file, as STRUCTURE-EPOCH.pdf and .html
    (-zh in Chinese). It tells of this epoch and those before it. The same results give the same bytes.

    Exit code 0: written, whatever the verdict, also where the epoch failed: the report says so.

    Parameters
    ----------
    epoch
        Epoch to report; the newest in the workspace where none is named.
    pdf
        File for the PDF.
    html
        File for the web page.
    lang
        en or zh.
    """
    from dashboard.report.page import html_of
    from dashboard.report.paper import pdf_of
    from storage.named_files import write_named_file

    campaign = load_with_workspace(file, workspace)
    facts, document = reported(campaign, workspace_of(campaign.folder, workspace), epoch, lang)
    targets = _targets(campaign, facts.epoch.epoch, lang, pdf, html)
    written = []
    for path, content in ((targets[0], pdf_of), (targets[1], lambda made: html_of(made).encode())):
        if path is not None:
            write_named_file(path, content(document))
            written.append(str(path))
            if not as_json:
                note(f"wrote {path}")
    if as_json:
        verdict = facts.now.tilt.verdict if facts.now.tilt else None
        return answer(0, {"epoch": facts.epoch.epoch, "lang": lang, "verdict": verdict, "written": written})
    return 0


def reported(campaign: "Campaign", workspace: Path, epoch: str | None, lang: str) -> "tuple[Facts, Document]":
    """Gather what the report of an epoch says, and write it in a language.

    Raises
    ------
    UsageError
        If there is no such epoch or language.
    StorageError
        If the workspace holds no epoch, or cannot be read.
    """
    from dashboard.report.document import document_of
    from dashboard.report.facts import gather
    from dashboard.report.words import words_of
    from storage.upgrade import ready_workspace

    words = words_of(lang)
    place = ready_workspace(workspace)
    facts = gather(_origin(place, campaign, _chosen(place, campaign, epoch)))
    return facts, document_of(facts, words)


def _chosen(place: "Workspace", campaign: "Campaign", epoch: str | None) -> "EpochRow":
    from storage.views import epoch_rows

    rows = epoch_rows(place, campaign.structure.id)
    if not rows:
        raise StorageError(
            f"{place.root} holds no epoch of {campaign.structure.id}; `tiltwatch run FILE` processes what is missing"
        )
    if epoch is None:
        return rows[-1]
    found = [row for row in rows if row.epoch == epoch]
    if not found:
        raise UsageError(f"unknown epoch {epoch!r}; in the workspace: {', '.join(row.epoch for row in rows)}")
    return found[0]


def _origin(place: "Workspace", campaign: "Campaign", epoch: "EpochRow") -> "Origin":
    from dashboard.report.facts import Origin
    from flows.version import VERSION
    from tasks.code_version import library_versions

    scheme, method = campaign.report.primary
    return Origin(
        place,
        campaign.structure.id,
        epoch.epoch,
        (scheme, method),
        _settings(place, epoch),
        library_versions(),
        VERSION,
    )


def _settings(place: "Workspace", epoch: "EpochRow") -> "Settings | None":
    """The settings with which the epoch was processed; None where they are not kept any more."""
    from dashboard.report.settings import settings_of
    from storage.ledger import read_settings, settings_path

    if not settings_path(place, epoch.campaign_digest).is_file():
        return None
    return settings_of(json.loads(read_settings(place, epoch.campaign_digest)))


def _targets(
    campaign: "Campaign", epoch: str, lang: str, pdf: Path | None, html: Path | None
) -> tuple[Path | None, Path | None]:
    if pdf is None and html is None:
        name = f"{campaign.structure.id}-{epoch}" + ("" if lang == "en" else f"-{lang}")
        pdf, html = campaign.folder / f"{name}.pdf", campaign.folder / f"{name}.html"
    return (
        None if pdf is None else pdf.expanduser().absolute(),
        None if html is None else html.expanduser().absolute(),
    )
