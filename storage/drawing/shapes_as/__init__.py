"""Formats of drawings: one a file, found by its ``NAME``; ``encode`` gives the bytes of the file."""
