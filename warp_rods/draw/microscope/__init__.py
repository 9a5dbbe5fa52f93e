"""Images of a run as a fluorescence microscope would take them, with the truth beside them: masks of every rod.

settings                             the microscope: a file in TOML, and what follows from a run
light                                rods as sources of light; the photons that each pixel expects
camera                               photons → counts: Poisson noise, gain, read noise, offset
masks                                which pixel belongs to which rod
export                               a folder of OME-TIFF files
"""
