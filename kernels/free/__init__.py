"""Free rods: active Kirchhoff rods in their twist-free frame (model §2; thesis chapter 4)."""
