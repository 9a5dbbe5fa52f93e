"""Ensembles of rods: parameters, state and step; one folder a kind of rod."""
