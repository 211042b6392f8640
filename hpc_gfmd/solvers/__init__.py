"""One solver per file; `base.py` says what a solver is, `drive.py` is the only loop."""
