"""Measurements of speed: solves, files, time against true error, and other codes on the same
surfaces."""
