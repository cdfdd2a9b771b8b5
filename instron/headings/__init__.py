"""What a heading says: words, units, quantities, and which columns a specimen has."""
