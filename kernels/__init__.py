"""Physics on the device: Warp functions that read like the equations, and kernels that index, call and store.

Nothing here imports more than Warp, and nothing here knows the order of things: that is the host's.
"""
