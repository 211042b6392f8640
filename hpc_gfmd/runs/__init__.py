"""Runs: scenes with their files, solves in memory, their solutions, and estimates of the cost."""
