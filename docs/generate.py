"""Write the pages that come from the code: `.venv/bin/python docs/generate.py`; a test holds them against it."""

from collections.abc import Iterator
from pathlib import Path

from storage.records import TABLES, columns_of
from tasks.axis import AXES
from tasks.contours import CONTOURS
from tasks.ingest import READERS
from tasks.limits import TABLES as LIMITS
from tasks.methods import methods_of
from tasks.preprocessing import KINDS
from tasks.preprocessing.kinds import StructureKind
from tasks.slicing import SCHEMES

HERE = Path(__file__).parent


def data_dictionary() -> str:
    """Every stored column with its unit and meaning."""
    return "\n".join(_dictionary_lines()) + "\n"


def variants() -> str:
    """Every variant: schemes, contours, axis estimators, readers, limits, kinds of structure."""
    return "\n".join(_variant_lines()) + "\n"


def _dictionary_lines() -> Iterator[str]:
    yield "# Data dictionary"
    yield ""
    yield "Made by `docs/generate.py` from `storage/records`. The same stands in `data_dictionary` of the catalog."
    yield "Parquet: `tables/<table>/<structure>/<epoch>.parquet`, `runs` by run. What does not exist is NULL."
    for name, record in TABLES.items():
        yield ""
        yield f"## {name}"
        yield ""
        yield (record.__doc__ or "").strip()
        yield ""
        yield "| column | type | unit | may be NULL | meaning |"
        yield "|---|---|---|---|---|"
        for column in columns_of(record):
            null = "yes" if column.nullable else ""
            yield f"| {column.name} | {column.python_type.__name__} | {column.unit} | {null} | {column.meaning} |"


def _variant_lines() -> Iterator[str]:
    yield "# Variants"
    yield ""
    yield "Made by `docs/generate.py`. A variant is one new file in its folder; it is found by itself."
    yield ""
    yield "## Slicing schemes (`tasks/slicing/`)"
    yield ""
    yield "| name | slices | measured with |"
    yield "|---|---|---|"
    for scheme in SCHEMES.values():
        measured = "; ".join(
            f"{m.name}: {m.contour}, {m.axis}, {m.thickness_m:g} m" for m in methods_of(scheme)
        )
        yield f"| {scheme.name} | {scheme.description} | {measured} |"
    for title, folder, found in (
        ("Contour models", "contours", {name: model.description for name, model in CONTOURS.items()}),
        ("Axis estimators", "axis", {name: axis.description for name, axis in AXES.items()}),
        ("Readers", "ingest", {r.name: ", ".join(r.suffixes) for r in READERS.values()}),
        ("Limits", "limits", {name: f"{t.document} ({t.kind}). {t.note}" for name, t in LIMITS.items()}),
        ("Kinds of structure", "preprocessing/kinds", {name: _kind(kind) for name, kind in KINDS.items()}),
    ):
        yield ""
        yield f"## {title} (`tasks/{folder}/`)"
        yield ""
        yield "| name | what |"
        yield "|---|---|"
        for name, what in sorted(found.items()):
            yield f"| {name} | {what} |"


def _kind(kind: StructureKind) -> str:
    low, high = kind.radius_window
    size = f"{kind.n_faces} plane faces, half the side" if kind.n_faces else "radius"
    return (
        f"base within {kind.position_slack_m:g} m of base_xy_m, lean up to {kind.max_lean:g}, "
        f"{size} {low:g} to {high:g} times the prior"
    )


if __name__ == "__main__":
    (HERE / "data-dictionary.md").write_text(data_dictionary(), encoding="utf-8")
    (HERE / "variants.md").write_text(variants(), encoding="utf-8")
