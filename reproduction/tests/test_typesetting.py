"""Plain text of reports as HTML."""
# ruff: noqa: RUF001

import pytest

from reproduction.typesetting import typeset


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("omega_z within 2.15e-5 rad/s", "<i>ω</i><sub>z</sub> within 2.15 × 10<sup>−5</sup> rad/s"),
        ("1e-13", "10<sup>−13</sup>"),
        ("3e+08 m^3", "3 × 10<sup>8</sup> m<sup>3</sup>"),
        ("a < b & c", "a &lt; b &amp; c"),
        ("changes by 0e+00", "changes by 0"),
        ("theta_0 = pi/8", "<i>θ</i><sub>0</sub> = <i>π</i>/8"),
        ("F_x and F_y on A", "<i>F</i><sub>x</sub> and <i>F</i><sub>y</sub> on A"),
        ("5.84 +- 0.29 km", "5.84 ± 0.29 km"),
        # Words, digests and versions stay as they are.
        ("theta-like thetas, 0x1e5, v1.2e3x", "<i>θ</i>-like thetas, 0x1e5, v1.2e3x"),
    ],
)
def test_typeset(text, html):
    assert typeset(text) == html
