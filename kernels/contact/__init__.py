"""Contact of rods with each other and with walls: pair forces, neighbour lists, boxes (docs/model.md §6)."""
