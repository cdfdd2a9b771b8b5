"""How numbers are written: decimal and thousands marks."""
