"""Where tables are in a text, their rows as numbers, and what becomes of every line."""
