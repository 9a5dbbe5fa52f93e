"""From a scene to a run folder.

layout, surfaces                     the surfaces and ensembles of a scene on a device
swimmers, filaments                  how each kind of rod is built and placed
loop, frames, hooks                  the loop from frame to frame, and user functions called during a run
watch, report                        warnings about results; messages of a run
runner, opening, saver               one run into its folder, with progress: how it begins, what it saves
run_folder, checkpoint, files        the folder: scene, trajectory, checkpoint; files replaced as a whole
starts, start_arrays                 shapes at the start that are from files, and what they are
measured_starts, run_starts          those of measured centre lines, and of rods of a run
begun, kept_surfaces, kept_starts    the run that a folder holds, and the surfaces and starts that it keeps
leftovers, storage                   what killed runs leave; full disks in words
interruption, stopping, portions     signals, and leaving a run between two frames
output                               variables that are saved
trajectory, store, chunks, document  the Zarr store of a trajectory: frames, arrays, files, metadata
reading, earlier                     reading it, and those of earlier versions
estimates, timing, check_scene       memory, disk and time that a run needs; what is said of a scene before a run
check                                looking for damage in a whole folder
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs={"loop": ["Simulation"]})
