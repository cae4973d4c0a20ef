"""Processes that live by another clock."""
