"""A run in files of other programs.

vtkhdf                               ParaView: rods with all variables, membrane and box over time
gsd                                  OVITO, MDAnalysis, HOOMD-blue: beads and bonds
simularium                           the Simularium viewer in a browser: fibres
wcon                                 trackers of worms: midlines
csv                                  anything that reads columns of text
saved, text, optional                positions without jumps; many numbers as text; packages that need not be installed
"""
