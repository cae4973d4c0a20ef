"""Decoders written by others, in child processes with limits: what they do to a scan they do to that scan alone."""
