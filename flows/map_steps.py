"""Map the surface of the shaft: local deviations beside the lean; nothing of the lean depends on it."""

from flows.epoch_work import EpochResult, EpochWork
from flows.stage_calls import artifact_of
from storage.artifacts import get_rows
from storage.records import SurfaceMapCell, SurfaceMapRow
from tasks.epoch_tables import Home
from tasks.exchange import plain
from tasks.plan import plan_mapped_axis, plan_surface_map
from tasks.quality_rows import surface_map_rows
from tasks.stages import map_whole_surface


def map_surface_of(work: EpochWork, result: EpochResult) -> None:
    """Map what the surface is off a straight shaft around the axis of the whole surface, and off the design."""
    wanted = plan_mapped_axis(work.campaign)
    refs = [o.lean_ref for o in result.outcomes if (o.scheme.name, o.method.name) == wanted]
    if not refs or refs[0] is None or result.shaft is None:
        return
    result.surface_map = work.calls.call(
        map_whole_surface,
        "surface map",
        shaft={name: artifact_of(result.shaft, name) for name in ("points", "stations", "model")},
        registration=artifact_of(result.registration, "registration"),
        lean=refs[0].to_json(),
        question=plain(plan_surface_map(work.campaign)),
    )
    if result.surface_map.refusal is not None:
        result.notes.append(f"surface map: {result.surface_map.refusal}")


def surface_map_of(work: EpochWork, result: EpochResult, home: Home) -> list[SurfaceMapRow] | None:
    """The rows of the map; None where the scheme that it rests on was not asked for."""
    if plan_mapped_axis(work.campaign) not in [(axis.scheme.name, axis.method.name) for axis in work.axes]:
        return None
    if result.surface_map is None or result.surface_map.refusal is not None:
        return []
    return surface_map_rows(
        home, get_rows(work.workspace, result.surface_map.artifacts["surface map"], SurfaceMapCell)
    )
