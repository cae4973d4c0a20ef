"""Runs that are killed at any moment and at every step, and what is looked at afterwards."""
