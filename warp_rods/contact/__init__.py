"""Contact: neighbours, walls, placement without overlap, and the steps that contact allows."""
