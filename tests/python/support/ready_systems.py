"""The names of the ready-made systems, and the orbits of satellites."""

import fullbody
import numpy as np

PUBLISHED = [
    *("antiope", "didymos", "didymos_after_dart", "dinkinesh", "eris_dysnomia", "fg3_1996", "haumea"),
    *("kalliope_linus", "lempo", "patroclus_menoetius", "pluto_charon", "sn263_2001"),
]
#: The physical 1999 KW4 is tabulated too; its default frame is that of the orbit. Of two orbits no pole is known.
WITHOUT_POLE = ["dp107_2000", "vh_1991"]
TABULATED = [*PUBLISHED, *WITHOUT_POLE, "kw4"]


def relative(state):
    """Position and velocity of the second body from the first."""
    return state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]


def orbit(system, state):
    return fullbody.KeplerElements.from_cartesian(*relative(state), system.mu(0, 1))


def orbit_pole(state):
    return np.degrees(fullbody.frames.pole_angles(np.cross(*relative(state))))
