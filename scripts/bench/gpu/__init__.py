"""The passes of an iteration, measured on a GPU."""
