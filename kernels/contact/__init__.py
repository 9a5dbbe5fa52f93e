"""What rods feel of each other and of their box: pair forces, lists of neighbours, walls."""
