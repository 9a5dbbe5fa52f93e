"""The animation of a run in USD.

export, clips                        the stage, written as one file or in parts
curves, tubes, membrane, load, box   rods, membrane, arrows of forces, box
materials, camera, blender           appearance, and a script for Blender
cables                               thickness, stiffness and natural shape, for simulators of cables
"""
