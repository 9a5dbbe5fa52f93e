"""``python -m warp_rods``."""

from warp_rods.cli import main

main()
