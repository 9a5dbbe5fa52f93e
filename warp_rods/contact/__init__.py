"""Contact: forces between rods, and of the walls of their box.

neighbours                           pair forces from neighbour lists
walls                                soft walls of a box
surroundings                         both, for the ensembles of a scene
arrangements, overlap, push          placement of rods without overlap
segments                             centre lines that come close, by the cells of a grid
rotations                            random frames
barrier                              warnings if steric forces are too weak to keep rods apart
"""
