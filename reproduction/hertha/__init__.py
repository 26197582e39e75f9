"""The rotation and the shape of (135) Hertha from its light curves, and its size from chords."""
