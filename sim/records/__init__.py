"""What a run leaves: what is watched, how it is written down and read back."""
