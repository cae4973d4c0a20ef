"""A cloud as LAS 1.4: 0.1 mm, the station of a point as its source id, the projected system where there is one."""

from typing import BinaryIO, Final

from storage.drawing.content import DrawnCloud
from storage.drawing.las_file import write_las

NAME: Final = "las"


def write(cloud: DrawnCloud, file: BinaryIO) -> None:
    """Write a cloud as LAS."""
    write_las(cloud, file, compress=False)
