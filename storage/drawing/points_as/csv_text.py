"""A cloud as CSV: east, north, up to 0.1 mm and the station of every point."""

from typing import BinaryIO, Final

from storage.drawing.cloud_tables import tables_of
from storage.drawing.content import DrawnCloud

NAME: Final = "csv"
DIGITS: Final = 4


def write(cloud: DrawnCloud, file: BinaryIO) -> None:
    """Write a cloud as CSV with a header."""
    from pyarrow import csv  # noqa: PLC0415 (slow to import)

    header = True
    for table in tables_of(cloud, DIGITS):
        how = csv.WriteOptions(include_header=header, quoting_style="needed")
        csv.write_csv(table, file, how)
        header = False
