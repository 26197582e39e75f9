"""1999 KW4 with its radar shapes: a year of exact gravity beside the equivalent ellipsoids."""
