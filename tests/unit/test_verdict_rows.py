"""Every limit of a campaign beside every axis of an epoch."""

from tasks.evaluation import Standard
from tasks.limits import MissingLimit, table_named, verdict
from tasks.verdict_rows import verdict_rows
from tests.storage.campaign import tilt_row

BRE, ACI = table_named("bre-digest-475"), table_named("aci117-general")
LATER = MissingLimit("own", "no version holds on 2025-03-14; the first is valid from 2026-01-01")


def test_construction_and_design_limits_stand_side_by_side_with_their_papers() -> None:
    tilt = tilt_row("e0")
    primary, beside = verdict_rows([tilt], Standard(102.0, BRE, ("F", "paper"), (), (ACI,)))
    assert (primary.limit_name, primary.is_primary, primary.kind) == ("bre-digest-475", True, "design")
    assert (beside.limit_name, beside.is_primary, beside.kind) == ("aci117-general", False, "construction")
    # 0.92 m of lean: a 250th of 102 m is 0.408 m, a thousandth 0.102 m
    assert {primary.verdict, beside.verdict} == {"fail"}
    for row, limit in ((primary, BRE), (beside, ACI)):
        judged = verdict(tilt.deviation_m, tilt.deviation_sigma_m, tilt.height_m, limit)
        assert (row.verdict, row.reason, row.allowable_m) == (
            judged.verdict,
            judged.reason,
            judged.allowable_m,
        )
        assert (row.version, row.document, row.edition, row.clause) == (
            limit.version,
            limit.document,
            limit.edition,
            limit.clause,
        )
        assert (row.deviation_m, row.sigma_m) == (tilt.deviation_m, tilt.deviation_sigma_m)


def test_a_limit_without_a_version_is_a_row_with_the_reason() -> None:
    (row,) = verdict_rows([tilt_row("e0")], Standard(102.0, LATER, ("F", "paper"), ()))
    assert (row.verdict, row.version, row.kind, row.allowable_m) == ("no limit", None, None, None)
    assert "the first is valid from 2026-01-01" in row.reason


def test_every_axis_is_judged_by_every_limit_and_by_none_where_none_is_named() -> None:
    tilts = [tilt_row("e0"), tilt_row("e0", scheme="B")]
    assert len(verdict_rows(tilts, Standard(102.0, None, ("F", "paper"), (), (ACI, BRE)))) == 4
    assert verdict_rows(tilts, Standard(102.0, None, ("F", "paper"), ())) == []
