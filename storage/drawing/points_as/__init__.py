"""Formats of clouds: one a file, found by its ``NAME``; ``write`` writes a cloud in pieces to a file that can seek."""
