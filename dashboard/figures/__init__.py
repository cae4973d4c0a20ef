"""Drawings for the web: pure functions from content to a plotly figure."""
