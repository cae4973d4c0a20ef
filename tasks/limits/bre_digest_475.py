"""Guidance on the tilt of chimneys and towers: one in 250."""

from tasks.limits.table import LimitKind, LimitTable, RatioRule

TABLE = LimitTable(
    name="bre-digest-475",
    version=1,
    rule=RatioRule(ratio=1.0 / 250.0, above_m=0.0, largest_m=None),
    kind=LimitKind.DESIGN,
    document="BRE Digest 475, Tilt of low-rise buildings, with particular reference to progressive "
    "foundation movement",
    edition="2003-03-10",
    clause="table of limit values of tilt for types of structure: chimneys and towers 1/250",
    source="the value from a mirror of the text with the sentence cut short; the publisher's abstract "
    "(standards.globalspec.com/std/1019686) confirms that there is a table and that chimneys are in it",
    verified_by=None,
    note="guidance, not a code; the validity in height was not seen",
)
