"""Derivatives of random systems of all kinds agree with differences of complete runs."""

import os

import pytest
from support.random_systems import TOLERANCE, asymmetry, case, errors

#: These cover all shapes, methods of gravity, integrators and forces; the acceptance run takes the first 200.
SEEDS = (3, 5, 8, 11, 13, 20, 23, 26, 29, 32, 36, 37, 44, 50, 53)
COUNT = int(os.environ.get("FULLBODY_RANDOM_SYSTEMS", "0"))
FIRST = int(os.environ.get("FULLBODY_FIRST_SEED", "1"))


@pytest.mark.parametrize("seed", range(FIRST, FIRST + COUNT) if COUNT else SEEDS)
def test_derivatives_of_random_systems_are_differences_of_runs(seed):
    tried = case(seed)
    for name, error in errors(tried).items():
        assert error < TOLERANCE, f"{name}: {tried.label}"
    if tried.is_hamiltonian:
        assert asymmetry(tried) < 1e-9, tried.label
