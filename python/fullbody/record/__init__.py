"""Integrators, and the record of a run: samples, the start, the continuous solution."""
