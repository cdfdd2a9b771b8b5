"""A scene at one instant as plain data, its effects, its step, and how it is kept."""
