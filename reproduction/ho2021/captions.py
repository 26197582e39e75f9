"""What the figures show: one caption each, for the report and for whoever reads ``numbers.json``."""

from __future__ import annotations

__all__ = ["CAPTIONS"]

#: By the figure's file name, in the report's order.
CAPTIONS = {
    "case1": (
        "As the paper's Fig. 2: (a) orbits, (b) z, (c, d) sines of the angles, (e, f) spins in the body frames. What "
        "(b) shows is round-off; its scale is in the label."
    ),
    "case1_force": "As Fig. 3: the force on A along z. It is round-off.",
    "case1_energy": (
        "As Fig. 4: energies; relative error of the energy, from step to step and from the start; error of the "
        "angular momentum. The share of the errors that are exactly zero, which no logarithmic axis shows, is in the "
        "legend."
    ),
    "case2": (
        "As Fig. 5, with the first 20 units of time of (c) and (d) drawn at large. The angle psi and the spin about "
        "z, which is constant, are left out, as in the paper."
    ),
    "case2_energy": (
        "As Fig. 6. The energy is constant to the last digit or two of double precision. Most of it is in the spins, "
        "so that its error is also given relative to the orbit's part."
    ),
    "elements": (
        "As Fig. 7: eccentricity, semi-major axis and inclination to the first orbit's plane. The bands of the first "
        "two reach from the smallest to the largest value within five orbits."
    ),
    "beta_spin": (
        "As Fig. 8: Beta's spin in the first 200 h. Grey: the ranges that the paper prints for ellipsoids, which the "
        "stated start does not give."
    ),
    "errors": (
        "Left: as Fig. 9, the largest errors from step to step. Right: the errors from the start. Most of the energy "
        "is in Alpha's spin, so that its error is also given relative to the orbit's part. The angular momentum "
        "drifts only where it is computed from the bodies' places, which travel away from the origin."
    ),
    "spin_starts": (
        "The range of Beta's spin in the first 200 h by start. From the left: all but Beta's attitude and spin ahead "
        "by some hours; Beta turned about the orbit's normal; Beta turned about its own pole; Beta spinning at "
        "another rate. Bottom: the largest of the six differences from the printed numbers, whose rounding is "
        "0.005e-5 rad/s."
    ),
    "inclination": (
        "Top: inclination of the orbit to the xy-plane through the year. Bottom: how long the orbit's node takes to "
        "go round the total angular momentum, by the inclination that the orbit starts with; prograde orbits on the "
        "left, retrograde ones on the right."
    ),
    "z_motion": (
        "Case 1's motion along z by kind of arithmetic: the largest abs(z) of A in windows of 25 units of time."
    ),
    "physical": (
        "The paper's start, whose orbit is retrograde to both spins; the same with the orbit turned into Beta's "
        "equator, and with Beta's equator turned into the orbit; and three prograde states."
    ),
}
