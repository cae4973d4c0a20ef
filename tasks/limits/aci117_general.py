"""Vertical alignment of concrete above 100 ft: one in a thousand, at most 6 in."""

from tasks.limits.table import LimitKind, LimitTable, RatioRule

FOOT_M = 0.3048
INCH_M = 0.0254

TABLE = LimitTable(
    name="aci117-general",
    version=1,
    rule=RatioRule(ratio=1.0 / 1000.0, above_m=100.0 * FOOT_M, largest_m=6.0 * INCH_M),
    kind=LimitKind.CONSTRUCTION,
    document="ACI 117, tolerances for concrete construction",
    edition="not known",
    clause="vertical alignment of lines, surfaces and arrises, height above 100 ft",
    source="a unified facilities guide specification that repeats it (ufgscriteriadocreport.tpub.com, 03700, page 26)",
    verified_by=None,
    note="general concrete, not chimneys; a tolerance of new work",
)
