"""The captions of the figures, for the report and for ``numbers.json``."""

from __future__ import annotations

__all__ = ["CAPTIONS"]

#: Captions by the figures' file names, in the report's order.
CAPTIONS = {
    "case1": (
        "As the paper's Fig. 2: (a) orbits, (b) z, (c, d) sines of the angles, (e, f) spins in the body frames. Panel "
        "(b) shows round-off; the label of its axis gives the scale."
    ),
    "case1_force": "As Fig. 3: the force on A along z. It is round-off.",
    "case1_energy": (
        "As Fig. 4: energies; relative error of the energy, from step to step and from the start; error of the angular "
        "momentum. The legend gives the share of the errors that are exactly zero, which a logarithmic axis cannot "
        "show."
    ),
    "case2": (
        "As Fig. 5, with the first 20 units of time of (c) and (d) enlarged. The angle psi and the spin about z, which "
        "is constant, are left out, as in the paper."
    ),
    "case2_energy": (
        "As Fig. 6. The energy is constant to the last digit or two of double precision. Most of it is rotational "
        "energy, so that its error is also given relative to the orbital energy."
    ),
    "elements": (
        "As Fig. 7: eccentricity, semi-major axis and inclination to the plane of the first orbit. The bands in the "
        "first two panels reach from the smallest to the largest value within five orbits."
    ),
    "beta_spin": (
        "As Fig. 8: Beta's spin in the first 200 h. Grey: the ranges that the paper prints for ellipsoids; they do not "
        "follow from the stated initial conditions."
    ),
    "errors": (
        "Left: as Fig. 9, the largest errors from step to step. Right: the errors from the start. Most of the energy "
        "is in Alpha's spin, so that its error is also given relative to the orbital energy. The angular momentum "
        "drifts only where it is computed from positions relative to the origin, from which the system moves away."
    ),
    "spin_starts": (
        "The range of Beta's spin in the first 200 h for families of initial conditions. From the left: everything "
        "except Beta's attitude and spin advanced by some hours; Beta rotated about the orbit's normal; Beta rotated "
        "about its own pole; Beta with another spin rate. Bottom: the largest of the six differences from the printed "
        "numbers, whose rounding error is up to 0.005e-5 rad/s."
    ),
    "inclination": (
        "Top: inclination of the orbit to the xy-plane through the year. Bottom: period of the precession of the "
        "orbit's node about the total angular momentum, as a function of the initial inclination; prograde orbits on "
        "the left, retrograde ones on the right."
    ),
    "z_motion": (
        "Motion along z in case 1 for several kinds of arithmetic: the largest abs(z) of A in windows of 25 units of "
        "time."
    ),
    "physical": (
        "The paper's initial state, whose orbit is retrograde with respect to both spins; the same state with the "
        "orbit rotated into the plane of Beta's equator, and with Beta's equator rotated into the plane of the orbit; "
        "and three prograde states."
    ),
}
