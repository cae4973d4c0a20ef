"""The charts of the report, one file a chart: SVG drawn by matplotlib, the same bytes for the same rows."""
