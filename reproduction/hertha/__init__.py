"""(135) Hertha: its size from the chords of an occultation."""
