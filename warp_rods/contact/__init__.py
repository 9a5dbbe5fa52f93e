"""Contact: forces between rods, and of the walls of their box.

neighbours                           pair forces from neighbour lists
walls                                soft walls of a box
surroundings                         both, for the ensembles of a scene
steps                                time steps under contact
arrangements, overlap                placement of rods without overlap
segments                             distances of centre lines
barrier                              warnings if steric forces are too weak to keep rods apart
"""
