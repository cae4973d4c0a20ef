"""Fit the whole surface of a shaft at once: axis and radius profile from all points (scheme S)."""
