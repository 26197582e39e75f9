"""The statements and numbers of the paper: Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "CASES_END",
    "CASES_LONG_END",
    "CASE_ERRORS",
    "CPU_TIME",
    "ERRORS",
    "EXCITED_E",
    "KW4_AXES",
    "SPIN",
    "SPIN_HOURS",
    "STATEMENTS",
    "YEAR",
    "YEAR_HOURS",
    "Statement",
    "Year",
]

#: The semi-axes in km as Table 2 prints them. The runs here use the authors' published input, with more digits.
KW4_AXES = ((0.766, 0.748, 0.674), (0.285, 0.232, 0.175))

#: The end of the dimensionless cases, and that of the long run of section 3.1.
CASES_END = 200.0
CASES_LONG_END = 2200.0

#: CPU time in seconds, Table 3.
CPU_TIME = {"case1": 22.8, "case2": 129.0, "ellipsoid": 4.6 * 3600.0, "spheroid": 1.1 * 3600.0}

#: Largest errors of the cases from step to step: relative of the energy, absolute of the angular momentum.
CASE_ERRORS = 1e-12

#: The eccentricity above which the excited state of Fahnestock & Scheeres (2008) is, as section 4 quotes it.
EXCITED_E = 0.03


#: The length of the run of 1999 KW4, hours.
YEAR_HOURS = 365.25 * 24.0


@dataclass(frozen=True, slots=True)
class Year:
    """The orbit of Beta about Alpha in one year, section 4 and Fig. 7.

    Attributes
    ----------
    e_max : float
        Largest eccentricity.
    a_min, a_max, a_mean : float
        Semi-major axis, km.
    period : float
        Mean orbital period, hours.
    inclination_period : float
        Time between two maxima of the inclination to the first orbit's plane, hours; "approximately" in the paper.
    """

    e_max: float
    a_min: float
    a_max: float
    a_mean: float
    period: float
    inclination_period: float


YEAR = {
    "ellipsoid": Year(0.0126, 2.5418, 2.5526, 2.5471, 17.4116, 3900.0),
    "spheroid": Year(0.0140, 2.5433, 2.5521, 2.5477, 17.4177, 3400.0),
}

#: The range of Beta's spin (ellipsoids, first 200 h), 1e-5 rad/s, Fig. 8. It does not follow from the stated start.
SPIN = {"x": (-1.89, 1.86), "y": (-3.20, 3.23), "z": (9.55, 11.16)}
SPIN_HOURS = 200.0

#: The largest relative errors of that run from step to step, Fig. 9.
ERRORS = {"energy": 1e-14, "angular_momentum": 1e-11}


@dataclass(frozen=True, slots=True)
class Statement:
    """A statement of the paper: its section or figure, the quantity, and the printed number or text."""

    section: str
    quantity: str
    text: str


def _statements() -> dict[str, Statement]:
    statements: dict[str, Statement] = {}

    def add(key: str, section: str, quantity: str, text: str) -> None:
        statements[key] = Statement(section, quantity, text)

    add("all.machine", "Abstract", "accuracy of the simulations", "machine accuracy level")
    add("all.pole", "2", "singularity of the angles at theta = 90 degrees", "not a problem for these cases")
    first = "3.1, Fig. 2"
    add("case1.z", first, "motion along z compared with that along x and y", "11 orders of magnitude smaller")
    add("case1.z_long", "3.1", "motion along z at t = 2200", "of order 1e-1")
    add("case1.xy_long", "3.1", "motion along x and y until t = 2200", "no significant changes")
    add("case1.force", "3.1, Fig. 3", "F_x and F_y on A", "of order 1e-1")
    add("case1.force_z", "3.1, 5, Fig. 3", "force along z on A", "present, because of the tilt")
    add("case1.tumbling", first, "turns about x and z", "multiple")
    add("case1.spin_z", first, "spin about z, both bodies", "constant")
    add("case1.rotational", "3.1, Fig. 4", "rotational energy noticeable from t", "about 75")
    add("case1.rise", "3.1, Fig. 2", "spins start to increase at t", "around 75")
    second = "3.2, Fig. 5"
    add("case2.z", second, "motion along z compared with that along x and y", "11 orders of magnitude smaller")
    add("case2.angles", second, "phi and theta oscillate between", "-pi/32 and pi/32")
    add("case2.psi", second, "psi", "increases linearly")
    add("case2.spin_z", second, "spin about z, both bodies", "constant at 2")
    add(
        "case2.transverse",
        "3.2",
        "spins about x and y compared with that about z",
        "roughly 3 orders of magnitude smaller",
    )
    add("case2.peaks", second, "spins about x and y are largest", "when the two are close")
    add("case2.coplanar", second, "orbits compared with those of coplanar spheroids", "closely resemble")
    add("case2.four_times", "3.2", "growth of the spins about x and y for theta_0 = pi/8", "nearly doubles")
    add("case2.rotational", "3.2, Fig. 6", "rotational energy compared with translational", "greater, nearly constant")
    for case, figure in (("case1", "3.1, Fig. 4"), ("case2", "3.2, Fig. 6")):
        add(f"{case}.energy_error", figure, "energy error, step to step, relative", f"< {CASE_ERRORS:.0e}")
        add(f"{case}.momentum_error", figure, "angular momentum error, step to step", f"< {CASE_ERRORS:.0e}")
        add(f"{case}.cpu", "Table 3", "CPU time to t = 200", f"{CPU_TIME[case]} s")
    for shape, p in YEAR.items():
        for name, quantity in (
            ("e_max", "largest eccentricity"),
            ("a_min", "smallest semi-major axis, km"),
            ("a_max", "largest semi-major axis, km"),
            ("a_mean", "mean semi-major axis, km"),
            ("period", "mean period, h"),
        ):
            add(f"kw4.{shape}.{name}", "4, Fig. 7", f"{quantity}, {shape}s", f"{getattr(p, name):.4f}")
        quantity = f"between maxima of the inclination, h, {shape}s"
        add(f"kw4.{shape}.inclination_period", "4, Fig. 7", quantity, f"about {p.inclination_period:.0f}")
    add("kw4.shape_a", "Abstract", "effect of the shape on the semi-major axis", "negligible")
    add("kw4.shape_e", "Abstract", "effect of the shape on the eccentricity", "negligible")
    add("kw4.shape_spin", "Abstract", "effect of the shape on Beta's spin z", "larger")
    add("kw4.mean_e", "5", "mean eccentricity", "larger for spheroids")
    add("kw4.a_order", "4, 5", "mean semi-major axis", "larger for spheroids")
    add("kw4.period_power", "4", "mean period with the mean semi-major axis", "proportional")
    add("kw4.period_order", "4", "mean period", "longer for spheroids")
    add("kw4.period_order_5", "5", "mean period", "longer for ellipsoids")
    add("kw4.inclination_order", "4, 5", "period of the inclination", "longer for ellipsoids")
    add("kw4.equal_periods", "4", "Beta's rotation period and its orbital period", "equal")
    add("kw4.synchronous", "4", "Beta's orbit", "synchronous")
    for axis, (low, high) in SPIN.items():
        quantity = f"Beta's spin {axis}, 200 h, 1e-5 rad/s, ellipsoids"
        add(f"kw4.spin_{axis}", "4, Fig. 8", quantity, f"[{low:.2f}, {high:.2f}]")
    add("kw4.spheroid.spin_z", "4, Fig. 8", "Beta's spin z, spheroids", "constant")
    add("kw4.spheroid.spin_xy", "4, Fig. 8", "Beta's spins x and y, spheroids", "as for ellipsoids")
    add("kw4.transverse", "4, 5", "Beta's spins x and y larger than in 2008", "because of its initial angles")
    add("kw4.excited_e", "4", "largest eccentricity compared with the excited state of 2008", f"below {EXCITED_E}")
    add("kw4.between_states", "4", "range of Beta's spin z", "between the relaxed and the excited state of 2008")
    add("kw4.similar_spin", "5", "Beta's spin z, ellipsoids, compared with 2008", "similar")
    for shape in YEAR:
        text = f"< {ERRORS['energy']:.0e}"
        add(f"kw4.{shape}.energy_error", "4, Fig. 9", f"energy error, step to step, relative, {shape}s", text)
    text = f"< {ERRORS['angular_momentum']:.0e}"
    add("kw4.momentum_error", "4, Fig. 9", "angular momentum error, each component, relative, ellipsoids", text)
    add("kw4.momentum_error_spheroid", "4", "angular momentum error, spheroids compared with ellipsoids", "similar")
    add("kw4.momentum_drift", "4, Fig. 9", "error of the angular momentum over the year", "drifts")
    add("all.errors", "5", "errors of energy and angular momentum, all runs", "< 1e-12")
    for shape in YEAR:
        add(f"kw4.{shape}.cpu", "Table 3", f"CPU time of the year, {shape}s", f"{CPU_TIME[shape] / 3600:.1f} h")
    return statements


#: Everything that the abstract, sections 3 to 5 and the tables state as a result, and section 2 of the cases; by key.
STATEMENTS = _statements()
