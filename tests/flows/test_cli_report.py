"""``tiltwatch report``: files where they are asked for, exit codes, JSON."""

from pathlib import Path

import pytest

from storage.ledger import store_settings
from tasks.settings import load_campaign
from tests.flows.calls import call
from tests.flows.stored_campaign import Stored, publish, publish_without_result, stored_campaign


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    """A campaign of which e1 is processed and e2 gave no result."""
    made = stored_campaign(tmp_path)
    settings = processed(made)
    publish(made, "e1", 0, **settings)
    publish_without_result(made, "e2", 1, state="failed", reason="no scan could be read", **settings)
    return made


def processed(stored: Stored) -> dict[str, str]:
    """Keep the settings of the campaign as a run does; what the rows of its epochs say of it."""
    campaign = load_campaign(stored.file)
    store_settings(stored.workspace, campaign.digest, campaign.filled_in_json())
    return {"campaign_digest": campaign.digest}


def test_both_files_come_beside_the_campaign_file_by_the_newest_epoch(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    called = call(capsys, "report", stored.file)
    assert (called.code, called.out) == (0, ""), "a failed epoch is reported, too"
    for kind in ("pdf", "html"):
        assert (stored.file.parent / f"chimney-01-e2.{kind}").stat().st_size > 10_000
        assert f"wrote {stored.file.parent}/chimney-01-e2.{kind}" in called.err


def test_one_file_alone_in_chinese_and_the_answer_as_json(
    capsys: pytest.CaptureFixture[str], stored: Stored, tmp_path: Path
) -> None:
    target = tmp_path / "out" / "r.html"
    words = ("--epoch", "e1", "--lang", "zh", "--html", target, "--json")
    called = call(capsys, "report", stored.file, *words)
    assert called.code == 0
    assert called.answer["written"] == [str(target)]
    assert (called.answer["epoch"], called.answer["verdict"]) == ("e1", "no limit")
    page = target.read_text(encoding="utf-8")
    assert '<html lang="zh">' in page
    assert "Heritage chimney" in page
    assert not list(tmp_path.glob("*.pdf"))


def test_unknown_epochs_and_languages_are_wrong_usage(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    called = call(capsys, "report", stored.file, "--epoch", "e9")
    assert called.code == 2
    assert "unknown epoch 'e9'; in the workspace: e1, e2" in called.err
    called = call(capsys, "report", stored.file, "--lang", "fr")
    assert called.code == 2
    assert "known: en, zh" in called.err


def test_a_campaign_that_was_never_processed_has_no_report(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    called = call(capsys, "report", stored_campaign(tmp_path).file)
    assert called.code == 3
    assert "tiltwatch run" in called.err
