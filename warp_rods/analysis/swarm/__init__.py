"""Measures of swarms.

order, motion, space, shapes         the measures
data                                 positions, boxes and pairs, for all of them
"""
