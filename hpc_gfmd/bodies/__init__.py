"""One elastic body per file; `base.py` says what a body is. Nothing outside this folder knows a
stiffness."""
