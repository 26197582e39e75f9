"""Statements of the abstract of Ho, Wold, Poursina & Conway (2022), and the assumptions of this study."""

from __future__ import annotations

from typing import Final

__all__ = ["ASSUMED", "GAP", "STATED", "G"]

#: The gravitational constant in km^3 / (kg h^2).
G: Final = 6.6743e-11 * 1e-9 * 3600.0**2
#: The gap between the surfaces at the start in km: 1 cm.
GAP: Final = 1e-5

STATED: Final = {
    "model": "both bodies are ellipsoids with exact mutual gravity; a contact binary at its spin fission limit",
    "gap": "the closest distance between the surfaces at the start is 1 cm",
    "tilt": "the secondary is rotated about its body-fixed y-axis: 45 tilts",
    "mass ratio": "37 mass ratios for each tilt",
    "cases": "six: three densities of the secondary and three shapes of it; 9,990 runs in all",
    "impacts": "more than 80 per cent of the runs end with an impact",
    "impacts by case": "collisions are more common with a less dense or a more elongated secondary",
    "pairs": "variations of the secondary's density and shape account for some of the spread of the rotation periods "
    "of observed asteroid pairs (not repeated here)",
    "secondary fission": "typically within the first five hours after the bodies separate",
    "secondary fission by case": "more common with a less dense or a more elongated secondary",
}
ASSUMED: Final = {
    "primary": "semi-axes 1, 0.7, 0.65 km, density 2000 kg/m^3",
    "A1, A2, A3": "the secondary has the primary's axis ratios and a density of 1200, 1600, 2000 kg/m^3",
    "B1, B2, B3": "the secondary has the primary's density and b/a, c/a of 0.9, 0.85; 0.6, 0.55; 0.5, 0.45",
    "tilts": "0 to 88 degrees by 2",
    "mass ratios": "0.01 to 0.37 by 0.01",
    "rate": "the spin at which the attraction of the secondary along the line of the centres equals the centripetal "
    "force of its circular motion; and 1 per cent more than that",
    "length": "200 days; an impact or an escape ends a run",
    "escape": "100 km apart, with positive energy of the relative motion as points",
    "secondary fission": "the secondary's spin reaches sqrt(2 pi G rho A1), at which dust at the end of its long axis "
    "has no weight (A1: the index symbol of that axis)",
}
