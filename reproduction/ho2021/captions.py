"""What the figures show: one caption each, for the report and for whoever reads ``numbers.json``."""

from __future__ import annotations

__all__ = ["CAPTIONS"]

#: By the figure's file name, in the report's order.
CAPTIONS = {
    "case1": (
        "As the paper's Fig. 2: (a) orbits, (b) z, (c, d) sines of the angles, (e, f) spins in the body "
        "frames. z is round-off."
    ),
    "case1_force": "As Fig. 3: the force on A along z.",
    "case1_energy": (
        "As Fig. 4: energies; relative error of the energy, step to step and from the start; error of the angular "
        "momentum."
    ),
    "case2": (
        "As Fig. 5, with the first 20 units of time of (c) and (d) at large. psi and the constant spin about z are "
        "left out, as in the paper."
    ),
    "case2_energy": (
        "As Fig. 6. The energy is constant to the last digit or two of double precision; most of it is in the "
        "spins, so the error is also given relative to the orbit's part."
    ),
    "elements": (
        "As Fig. 7: eccentricity, semi-major axis, inclination to the first orbit's plane; bands are the "
        "range over five orbits."
    ),
    "beta_spin": "As Fig. 8: Beta's spin over 200 h; grey: the ranges that the paper prints for ellipsoids.",
    "errors": (
        "Left: as Fig. 9, the largest errors from step to step. Right: from the start; most of the energy is in "
        "Alpha's spin, so the error is also given relative to the orbit's part. The angular momentum drifts "
        "in its evaluation alone, from places that travel away from the origin."
    ),
    "spin_starts": (
        "Range of Beta's spin in the first 200 h by start: Beta farther along its orbit, turned about the "
        "orbit's normal, turned about its own pole, spinning faster or slower."
    ),
    "inclination": (
        "Top: inclination to the first orbit's plane. Middle: inclination to the xy-plane. Bottom: how long "
        "the orbit's node takes round the total angular momentum, by the inclination that the orbit starts "
        "with; prograde left, retrograde right. Bars reach to a fit over twice the time: it does not go round evenly "
        "from every start."
    ),
    "z_motion": "Case 1's motion along z by kind of arithmetic.",
    "physical": (
        "The paper's start, retrograde to both spins; the same with the orbit in Beta's equator, and with Beta's "
        "equator in the orbit; prograde ones."
    ),
}
