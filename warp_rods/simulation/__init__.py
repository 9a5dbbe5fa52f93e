"""From a scene to a run folder.

layout, surfaces                     a scene laid out on a device: its surfaces and ensembles
loop, frames, hooks                  stepping from frame to frame, and functions that are called on the way
watch, report                        what throws doubt on the answers; what a run says
runner                               one run into its folder, with progress
run_folder                           the folder: scene, trajectory, checkpoint
trajectory, store, earlier           the Zarr store of a trajectory, and those of earlier versions
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs={"loop": ["Simulation"]})
