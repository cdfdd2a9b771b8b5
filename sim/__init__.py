"""Cosserat rods in contact, a tine that combs them, and their exact topology."""
