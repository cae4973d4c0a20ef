"""Take in stations as they arrive, tell the crew what is missing, and run the flow when an epoch is complete."""
