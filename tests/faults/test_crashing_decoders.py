"""A run in which the decoder of one scan crashes: that scan is refused, and the run goes on."""

import sys
from pathlib import Path

import pytest

from storage.decoders.pool import DecoderPool
from tests.faults.sites import FIRST, SECOND, Site, state_of
from tests.unit.decoders.doubles import spoilt_pool

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="ends of processes have other names there")
BAD = "ST02"


@pytest.fixture
def deed() -> str:
    """What the decoders do."""
    return "segfault"


@pytest.fixture
def spoilt(unpublished: Site, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deed: str) -> DecoderPool:
    """Decoders that do it on a station whose scan is new."""
    content = bytearray(unpublished.scan(BAD).read_bytes())
    content[58:64] = b"newer\0"  # the program that wrote it, as the header says
    unpublished.scan(f"{BAD}-bad").write_bytes(content)
    text = unpublished.text().replace(f"{SECOND}/{BAD}.laz", f"{SECOND}/{BAD}-bad.laz")
    unpublished.file.write_text(text, encoding="utf-8")
    pool = spoilt_pool(tmp_path, ".laz", deed)
    monkeypatch.setattr("tasks.ingest.laz_decoder.DECODERS", pool)
    return pool


@pytest.mark.slow
def test_a_decoder_that_crashes_costs_its_scan_and_not_the_run(
    unpublished: Site, spoilt: DecoderPool
) -> None:
    called = unpublished.run("--scheme", "A", "--json")
    assert called.code == 3
    assert [state_of(called, epoch)["state"] for epoch in (FIRST, SECOND)] == ["ok", "degraded"]
    stations = unpublished.stations(SECOND)
    assert {station for station, row in stations.items() if row.state == "failed"} == {BAD}
    assert "SIGSEGV" in str(stations[BAD].reason)
    assert unpublished.tilts(SECOND)["A/robust"].n_centres > 50
    spoilt.end_idle()


@pytest.mark.parametrize(
    ("deed", "again"), [pytest.param("segfault", False, marks=pytest.mark.slow), ("be_killed", True)]
)
def test_a_run_says_whether_it_may_go_better_next_time(
    unpublished: Site, spoilt: DecoderPool, *, again: bool
) -> None:
    called = unpublished.run("--scheme", "A", "--epoch", SECOND, "--json")
    assert state_of(called, SECOND)["storage_fault"] is again
    spoilt.end_idle()
