"""Shapes, bodies, states and forces: the objects of which systems are made and that they return."""
