"""Design a survey before going out: what lean sigma a set of stations will give."""
