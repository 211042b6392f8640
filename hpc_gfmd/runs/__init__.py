"""Runs: a scene with its files, a solve in memory, the solutions of both, and estimates of their
cost.
"""
