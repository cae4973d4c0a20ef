"""The two points that the paper quotes for the centre line of a concrete chimney."""

from tasks.limits.table import LimitKind, LimitPoint, LimitTable, PointsRule

TABLE = LimitTable(
    name="gb50078-concrete-quoted",
    version=1,
    rule=PointsRule((LimitPoint(100.0, 0.060), LimitPoint(120.0, 0.065))),
    kind=LimitKind.CONSTRUCTION,
    document="GB 50078, construction and acceptance of chimneys",
    edition="2008",
    clause="verticality of the centre line of a reinforced concrete shaft; number not known",
    source="as quoted by Zhou et al. 2025, Buildings 15, 3046, section 4.3, from its reference [54]",
    verified_by=None,
    note="a tolerance of new work; the quotation does not name the standard, GB 50078 is what it looks like; "
    "other heights of the table are not public, so none are given",
)
