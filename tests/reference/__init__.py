"""Exact solutions and independent NumPy versions for comparison in tests."""
