"""A cloud as LAZ: the LAS file of it, compressed without loss."""

from typing import BinaryIO, Final

from storage.drawing.content import DrawnCloud
from storage.drawing.las_file import write_las

NAME: Final = "laz"


def write(cloud: DrawnCloud, file: BinaryIO) -> None:
    """Write a cloud as LAZ."""
    write_las(cloud, file, compress=True)
