"""Contact: what rods feel of each other and of their box.

neighbours                           pair forces over lists of neighbours
walls                                soft walls of a box
surroundings                         both, for the ensembles of a scene
steps                                the steps that contact allows
arrangements, overlap                places for rods without overlap
barrier                              whether steric forces keep rods apart
"""
