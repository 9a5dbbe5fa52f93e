"""Free rods: active Kirchhoff rods in their twist-free frame (docs/model.md §2; dissertation, chapter 4)."""
