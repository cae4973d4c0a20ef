"""The stages of the measurement, one folder each, pure inside; stages.py makes cached tasks of them."""
