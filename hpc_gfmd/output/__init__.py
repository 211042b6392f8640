"""The result file and what can be read out of it."""
