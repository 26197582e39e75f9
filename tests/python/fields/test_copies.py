"""The rotating frame of a pair goes to other processes."""

import copy
import pickle
import warnings

import fullbody
import numpy as np
import pytest
from fullbody.errors import InconsistentInput


def test_a_rotating_frame_can_be_copied_and_pickled():
    system, state = fullbody.systems.kw4(units=True)
    with pytest.warns(InconsistentInput, match="rotating frame"):
        frame = fullbody.fields.Synodic(system, state)
    point = [0.5, 2.0, 0.1]
    for make in (copy.copy, copy.deepcopy, lambda frame: pickle.loads(pickle.dumps(frame))):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            other = make(frame)
        assert repr(other) == repr(frame)
        assert (other.jacobi(point), other.rate) == (frame.jacobi(point), frame.rate)
        np.testing.assert_array_equal(other.position, frame.position)
