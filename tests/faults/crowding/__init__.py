"""Eight processes on one workspace: running, reading, watching, verifying, reporting."""
