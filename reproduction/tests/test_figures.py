"""The report's figures: units on every axis, nothing in a legend that is not drawn, nothing drawn twice."""

from types import SimpleNamespace

import fullbody
import numpy as np
import pytest

from reproduction.ho2021 import (
    case_figures,
    cases,
    drawing,
    evidence_figures,
    kw4,
    kw4_figures,
    paper,
    spin,
    symmetry,
    years,
)


@pytest.fixture(scope="module")
def runs():
    return {number: cases.case(number)[0] for number in (1, 2)}


@pytest.fixture(scope="module")
def halves():
    return {shape: kw4.run_year(shape, "focal", 220.0)[0] for shape in kw4.SHAPES}


@pytest.fixture(scope="module")
def evidence(halves):
    t = np.arange(12.5, 250.0, 25.0)
    motions = {name: symmetry.Motion(t, 10.0**k * np.exp(0.01 * t)) for name, k in (("seeded", -11), ("double", -16))}
    motions |= {"compensated": symmetry.Motion(t, 1e-17 * t), "symmetric": symmetry.Motion(t, 0 * t)}
    spins = spin.PRINTED + 0.1 * np.sin(np.arange(5.0))[:, None, None]
    scans = [
        spin.Scan(name, unit, stated, stated + half_range * np.linspace(-1, 1, 5), spins)
        for name, (unit, stated, half_range, _) in spin.FAMILIES.items()
    ]
    tilts, periods = np.array([45.0, 120.0, 156.1]), np.array([3000.0, 6000.0, 4000.0])
    nodal = {shape: years.Nodal(tilts, periods - k) for k, shape in enumerate(kw4.SHAPES)}
    return SimpleNamespace(z_motion=motions, scans=scans, nodal=nodal, runs=SimpleNamespace(year=halves))


@pytest.fixture(scope="module")
def figures(runs, halves, evidence):
    return {
        **{f"motion {number}": case_figures.motion(run, number) for number, run in runs.items()},
        **{f"energy {number}": case_figures.energy(run, number) for number, run in runs.items()},
        "force": case_figures.force(runs[1], cases.forces(runs[1])),
        **kw4_figures.all_figures(halves),
        "z_motion": evidence_figures.z_motion(evidence),
        "spin_starts": evidence_figures.spin_starts(evidence),
        "inclination": evidence_figures.inclination(evidence),
    }


def test_windows_have_their_smallest_and_largest_values():
    x = np.arange(8.0)
    middle, low, high = drawing.windows(x, np.array([3.0, -5.0, 1.0, 2.0, 0.0, 0.0, 7.0, -8.0]), 2.0)
    assert middle.tolist() == [0.5, 2.5, 4.5, 6.5]
    assert low.tolist() == [-5.0, 1.0, 0.0, -8.0]
    assert high.tolist() == [3.0, 2.0, 0.0, 7.0]
    middle, high = drawing.largest(x, np.array([3.0, -5.0, 1.0, 2.0, 0.0, 0.0, 7.0, -8.0]), 2.0)
    assert (middle.tolist(), high.tolist()) == ([0.5, 2.5, 6.5], [5.0, 2.0, 8.0])


def test_every_axis_has_its_unit(figures):
    for name, figure in figures.items():
        labels = [text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel()) if text]
        assert len(labels) >= 2, name
        for text in labels:
            assert any(
                word in text for word in ("dimensionless", "relative", "km]", "deg]", "h]", "/s]", "unit time]")
            ), (name, text)


def test_every_entry_of_a_legend_is_drawn(figures):
    for name, figure in figures.items():
        for ax in figure.axes:
            for handle, text in zip(*ax.get_legend_handles_labels(), strict=True):
                if hasattr(handle, "get_ydata"):
                    assert np.isfinite(np.asarray(handle.get_ydata(), dtype=float)).any(), (name, text)


def test_no_curve_is_drawn_over_itself(figures):
    for name, figure in figures.items():
        for k, ax in enumerate(figure.axes):
            drawn = [line.get_xydata().tobytes() for line in ax.lines]
            assert len(set(drawn)) == len(drawn), (name, k)


def test_exactly_symmetric_rates_are_a_note_and_no_curve(figures):
    (ax,) = figures["z_motion"].axes
    assert len(figures["z_motion"].legends[0].get_texts()) == 3
    assert any("z = 0 throughout" in text.get_text() for text in ax.texts)
    low, high = ax.get_ylim()
    assert low < 1e-18
    assert high > 0.1


@pytest.mark.parametrize("number", [1, 2])
def test_energies_share_their_time_axis(figures, number):
    for ax in figures[f"energy {number}"].axes:
        assert ax.get_xlim() == (0.0, paper.CASES_END)


def test_a_short_run_shows_the_elements_themselves(figures, halves):
    panels = [(values, run) for values in ("e", "a") for run in halves.values()]
    for ax, (values, run) in zip(figures["elements"].axes, panels, strict=False):
        (line,) = ax.lines
        elements = getattr(run.elements(), values)
        np.testing.assert_array_equal(line.get_ydata(), getattr(elements, "value", elements))


def test_a_year_has_a_panel_for_the_range_of_each_shape(halves):
    """The bands of the two shapes would cover each other; the panels have the same scale."""
    coarse = fullbody.SymplecticSplitting(1.0)
    runs = {s: half.system.integrate(half[0], 1000.0, integrator=coarse) for s, half in halves.items()}
    figure = kw4_figures.elements(runs)
    panels = [(values, run) for values in ("e", "a") for run in runs.values()]
    for ax, (values, run) in zip(figure.axes, panels, strict=False):
        (band,) = ax.collections
        low, high = band.get_datalim(ax.transData).intervaly
        elements = getattr(run.elements(), values)
        elements = getattr(elements, "value", elements)
        assert (low, high) == (elements.min(), elements.max())
        assert band.get_hatch() is None
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()


def test_errors_of_one_digit_are_inside_the_limits_of_the_axis(figures, runs):
    """Case 2's energy changes by the spacing of doubles near it, at its size 2**-51."""
    ax = figures["energy 2"].axes[1]
    low, high = ax.get_ylim()
    spacing = 2.0**-51 / runs[2].energy[0]
    assert low < spacing / 2
    assert high > 2 * np.abs(runs[2].energy_drift_orbital).max()
    smallest = min(line.get_ydata().min() for line in ax.lines)
    assert smallest == pytest.approx(spacing, rel=1e-12)


def test_scans_mark_the_start_of_the_paper(figures, evidence):
    axes = np.reshape(figures["spin_starts"].axes, (4, -1))
    for column, scan in zip(axes.T, evidence.scans, strict=True):
        assert f"[{scan.unit}]" in column[3].get_xlabel().replace("\n", " ")
        for ax in column:
            assert any(np.all(np.asarray(line.get_xdata()) == scan.stated) for line in ax.lines)
