"""Displacements of a system on its orbit about the Sun by changes of the six elements."""

from __future__ import annotations

import numpy as np

from ..base.differences import difference
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..orbit.elements import DIMENSIONS, KeplerElements
from ..typing import Floats
from .times import kilometres, seconds
from .vectors import SystemGeometry, cached_rotation

#: The elements that have corrections, with their dimensions.
ELEMENTS = DIMENSIONS
#: The step of a difference, relative to the semi-major axis, and absolute for the other elements.
_STEP = 1e-6


def displacements(system: SystemLike, local: SystemGeometry, times: Floats) -> list[Floats]:
    """Return the displacements (K, 3) of the barycentre by each element, per unit of it, in the system's axes.

    The orbit is that which osculates the path of the geometry at the mean of the times (K,), and its elements refer to
    the ecliptic of J2000. A geometry whose Sun does not move, or whose path is no orbit about the Sun, is refused.
    """
    from astropy.constants import GM_sun

    what = "corrections of the heliocentric elements"
    mu = float(GM_sun.to_value("km3 / s2")) / kilometres(system, what) ** 3 * seconds(system, what) ** 2
    axes = cached_rotation(system.context.frame, "ecliptic")
    middle = np.array([np.mean(times)])
    emitted = local.emission(np.append(times, middle))
    position, velocity = (-part[0] @ axes.T for part in (local.sun(middle), local.sun_velocity(middle)))
    # The Sun's vectors are given by the time of arrival.
    observer, observer_velocity = local.observer(middle)[0], local.observer_velocity(middle)[0]
    delay_rate = observer @ observer_velocity / np.linalg.norm(observer) / local.light_speed
    if not np.linalg.norm(velocity) > 0.0:
        raise InvalidInput(f"{what} need a geometry in which the Sun moves; expected vectors to_sun for each time")
    try:
        orbit = KeplerElements.from_cartesian(position, velocity / (1.0 - delay_rate), mu)
    except InvalidInput as error:
        raise InvalidInput(f"{what} need a geometry along an orbit about the Sun: {error}") from error
    elements = {name: float(getattr(orbit, name)) for name in ELEMENTS}
    elapsed = emitted[:-1] - emitted[-1]

    def positions(name: str, change: float) -> Floats:
        """Return the positions (K, 3) with one element changed."""
        changed = elements | {name: elements[name] + change}
        rate = np.sqrt(mu / abs(changed["a"]) ** 3)
        rows = {key: np.full(len(times), value) for key, value in changed.items()}
        rows["M"] = rows["M"] + rate * elapsed
        return np.asarray(KeplerElements(**rows).to_cartesian(mu)[0] @ axes)

    def by_element(name: str) -> Floats:
        reference = positions(name, 0.0)
        step = _STEP * abs(elements["a"]) if name == "a" else _STEP
        return difference(lambda change: positions(name, change) - reference, step)

    return [by_element(name) for name in ELEMENTS]
