"""A cloud as tables, piece by piece: east, north, up and the station of every point."""

from collections.abc import Iterator

import numpy as np
import pyarrow as pa

from storage.drawing.content import DrawnCloud


def schema_of_cloud(cloud: DrawnCloud) -> pa.Schema:
    """Columns of a cloud; what the coordinates are stands in the metadata."""
    about = {
        "tiltwatch": "cloud",
        "structure": cloud.structure,
        "epoch": cloud.epoch,
        "epoch_time": cloud.epoch_time.isoformat(),
        "frame": cloud.frame.meaning,
    }
    coordinates = [
        pa.field(name, pa.float64(), metadata={"unit": "m"}) for name in ("east_m", "north_m", "up_m")
    ]
    station = pa.field("station", pa.dictionary(pa.int32(), pa.string()))
    return pa.schema([*coordinates, station], metadata=about)


def tables_of(cloud: DrawnCloud, digits: int | None = None) -> Iterator[pa.Table]:
    """Give a cloud piece by piece, its coordinates rounded to so many digits where a number of them is given."""
    schema = schema_of_cloud(cloud)
    names = pa.array(list(cloud.stations), pa.string())
    for points_m, station in cloud.pieces():
        told = points_m if digits is None else np.round(points_m, digits)
        stations = pa.DictionaryArray.from_arrays(pa.array(station.astype(np.int32)), names)
        columns = [*(pa.array(np.ascontiguousarray(told[:, axis])) for axis in range(3)), stations]
        yield pa.Table.from_arrays(columns, schema=schema)
