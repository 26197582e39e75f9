"""What Hera should find at Didymos and Dimorphos: a prediction dated 2026-11-25."""
