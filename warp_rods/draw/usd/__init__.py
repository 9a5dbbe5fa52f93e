"""The animation of a run in USD.

export                               ``export_usd``, which makes the file
curves, membrane, load, box          rods, membrane, arrows of the load, box
materials, camera                    appearance
"""
