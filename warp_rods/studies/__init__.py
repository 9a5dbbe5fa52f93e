"""Parameter studies: a scene with a [sweep] at every point of a grid, on one core, all cores, or a cluster.

``axes`` and ``plan`` say which points there are and what the scene of each is; ``points`` simulates some of them, as
rods of one batch where rods do not feel each other; ``columns`` and ``store`` keep what was measured; ``tasks`` are the
parts in which that is done; ``dispatch`` gives them to a ``cluster`` of Dask, and ``serial`` does them without one;
``begin``, ``sweep`` and ``refine`` are the whole, at which ``check``, ``status`` and ``plot`` look.
"""
