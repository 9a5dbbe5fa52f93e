"""Other ways to solve the same problems, each as its user would write it; ``numba`` and PyElastica may be missing."""
