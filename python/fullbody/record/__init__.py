"""What a run is made by and keeps: integrators, samples, the start, the continuous solution."""
