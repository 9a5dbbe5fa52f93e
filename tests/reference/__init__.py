"""Exact answers and NumPy twins that the tests compare with."""
