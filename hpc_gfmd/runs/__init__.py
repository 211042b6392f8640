"""A run: a scene with its files, a solve in memory, the solutions of both, and what a run takes."""
