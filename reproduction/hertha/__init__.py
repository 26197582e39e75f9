"""The rotation and the shape of (135) Hertha from its light curves."""
