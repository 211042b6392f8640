"""One figure or table of the paper per file; see catalogue."""
