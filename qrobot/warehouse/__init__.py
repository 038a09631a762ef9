"""Shortest tours and routing policies of aisle warehouses."""
