"""From a scene to a run folder.

layout, surfaces                     the surfaces and ensembles of a scene on a device
loop, frames, hooks                  the loop from frame to frame, and user functions called during a run
watch, report                        warnings about results; messages of a run
runner                               one run into its folder, with progress
run_folder                           the folder: scene, trajectory, checkpoint
trajectory, store, earlier           the Zarr store of a trajectory, and those of earlier versions
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs={"loop": ["Simulation"]})
