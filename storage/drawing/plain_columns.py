"""A drawing as a table: a row a shape, coordinates first, then all that is known of any of them."""

from collections.abc import Mapping, Sequence

from storage.drawing.content import Circle, Drawing, Ellipse, Line, Point, Shape, Value

COORDINATES = ("east_m", "north_m", "up_m", "to_east_m", "to_north_m", "to_up_m", "larger_m", "smaller_m")


def columns_of_drawing(drawing: Drawing) -> dict[str, list[Value]]:
    """Columns by name; ``wkt`` has the place or line for programs that read well-known text, of circles the centre."""
    rows = [
        {
            "structure": drawing.structure,
            "epoch": drawing.epoch,
            "epoch_time": drawing.epoch_time.isoformat(),
            "layer": feature.layer,
            **_numbers_of(feature.shape),
            **feature.attributes,
            "wkt": _well_known_text(feature.shape),
        }
        for feature in drawing.features
    ]
    names = _in_order(rows)
    return {name: [row.get(name) for row in rows] for name in names}


def _in_order(rows: Sequence[Mapping[str, Value]]) -> list[str]:
    names = dict.fromkeys(name for row in rows for name in row if name != "wkt")
    return [*names, "wkt"]


def _numbers_of(shape: Shape) -> dict[str, Value]:
    start, end = _ends(shape)
    larger = smaller = None
    if isinstance(shape, Ellipse):
        larger, smaller = shape.larger_m, shape.smaller_m
    return dict(zip(COORDINATES, (*start, *end, larger, smaller), strict=True))


def _ends(
    shape: Shape,
) -> tuple[tuple[float, float, float], tuple[float, float, float] | tuple[None, None, None]]:
    match shape:
        case Line(start, end):
            return start, end
        case Point(at):
            return at, (None, None, None)
        case Circle() | Ellipse():
            return shape.center, (None, None, None)


def _well_known_text(shape: Shape) -> str:
    start, end = _ends(shape)
    first = " ".join(f"{value:.4f}" for value in start)
    if end[0] is None:
        return f"POINT Z ({first})"
    return f"LINESTRING Z ({first}, {' '.join(f'{value:.4f}' for value in end)})"
