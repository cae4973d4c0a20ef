import pytest

from storage.errors import InputError, ShapeError
from tasks.geometry.failure import FitFailure
from tasks.limits import TABLES, LimitKind, LimitTable, allowable, table_named, table_of_points

FOOT_M = 0.3048


def test_shipped_are_the_three_tables_that_could_be_traced_to_a_public_text() -> None:
    assert sorted(TABLES) == ["aci117-general", "bre-digest-475", "gb50078-concrete-quoted"]


@pytest.mark.parametrize("name", TABLES)
def test_every_shipped_table_says_what_it_is_and_claims_no_verification(name: str) -> None:
    table = TABLES[name]
    assert all((table.document, table.edition, table.clause, table.source, table.note))
    assert table.version >= 1
    assert table.kind is not LimitKind.UNSTATED
    assert table.verified_by is None
    assert "not verified against the document" in table.described


@pytest.mark.parametrize("name", TABLES)
def test_every_shipped_table_allows_less_than_a_hundredth_of_the_height(name: str) -> None:
    limit_m = allowable(TABLES[name], 110.0)
    assert isinstance(limit_m, float)
    assert 0.0 < limit_m < 1.1


def test_unknown_table_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        InputError, match=r"unknown limit table 'gb50078'; known: aci117-general, bre-digest-475, gb50078"
    ):
        table_named("gb50078")


@pytest.mark.parametrize(
    ("height_m", "limit_m"), [(100.0, 0.060), (102.0, 0.0605), (110.0, 0.0625), (120.0, 0.065)]
)
def test_quoted_points_are_interpolated_linearly(height_m: float, limit_m: float) -> None:
    assert allowable(table_named("gb50078-concrete-quoted"), height_m) == pytest.approx(limit_m, abs=1e-15)


@pytest.mark.parametrize("height_m", [99.99, 120.01, 20.0, 300.0])
def test_quoted_points_give_no_limit_outside_them(height_m: float) -> None:
    limit = allowable(table_named("gb50078-concrete-quoted"), height_m)
    assert isinstance(limit, FitFailure)
    assert limit.reason == (
        f"gb50078-concrete-quoted: the table holds from 100 m to 120 m; the height is {height_m:g} m"
    )


def test_guidance_is_one_in_250() -> None:
    assert allowable(table_named("bre-digest-475"), 102.0) == pytest.approx(0.408, abs=1e-12)


@pytest.mark.parametrize(("height_m", "limit_m"), [(102.0, 0.102), (152.4, 0.1524), (200.0, 0.1524)])
def test_general_concrete_is_one_in_a_thousand_up_to_six_inches(height_m: float, limit_m: float) -> None:
    assert allowable(table_named("aci117-general"), height_m) == pytest.approx(limit_m, abs=1e-12)


def test_general_concrete_gives_no_limit_up_to_100_ft() -> None:
    limit = allowable(table_named("aci117-general"), 100 * FOOT_M)
    assert isinstance(limit, FitFailure)
    assert "holds above 30.48 m" in limit.reason


@pytest.mark.parametrize("height_m", [0.0, -5.0, float("nan")])
def test_a_height_that_is_not_above_zero_is_refused(height_m: float) -> None:
    with pytest.raises(ShapeError, match="height_m above 0"):
        allowable(table_named("bre-digest-475"), height_m)


def own() -> LimitTable:
    return table_of_points([[50.0, 0.04], [100.0, 0.06], [120.0, 0.065]], LimitKind.IN_SERVICE)


def test_own_points_are_interpolated_and_keep_their_kind() -> None:
    assert allowable(own(), 75.0) == pytest.approx(0.05, abs=1e-15)
    assert "an in-service limit" in own().described


def test_own_points_without_kind_say_so() -> None:
    assert "a limit of unstated kind" in table_of_points([[100.0, 0.06]]).described


def test_a_single_own_point_holds_at_its_height_only() -> None:
    table = table_of_points([[100.0, 0.06]])
    assert allowable(table, 100.0) == 0.06
    assert isinstance(allowable(table, 100.1), FitFailure)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], "at least one pair"),
        ([[100.0, 0.06, 1.0]], "at least one pair"),
        ([[100.0, 0.06], [100.0, 0.07]], "heights that increase"),
        ([[120.0, 0.06], [100.0, 0.07]], "heights that increase"),
        ([[100.0, 0.0]], "above 0, in metres"),
        ([[100.0, float("nan")]], "above 0, in metres"),
    ],
)
def test_own_points_that_make_no_table_are_refused(points: list[list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        table_of_points(points)
