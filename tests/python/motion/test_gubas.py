"""Two polyhedra as GUBAS moves them, with the mutual potential to the fourth order."""

import shutil

import fullbody
import numpy as np
from support import DATA
from support.meshes import close, octahedron

#: The state after 7,200 s in the binary output of GUBAS, in km and s: separation and relative velocity in the
#: inertial frame, spins in the frames of the bodies, attitudes. Commit 8db57ff of github.com/meyeralexj/gubas,
#: built by g++ 12 with Armadillo 11.4; order 4, "RK 7(8)", tolerance 1e-14, the settings of gubas_octahedra.cfg.
TIME = 7200.0
SEPARATION = [1.0928980318026158, 1.0088264674566214, -0.04181358824015174]
VELOCITY = [-0.0001979310013566266, 0.00010085191370598868, 9.101075430820952e-05]
SPINS = [
    [1.774344254995445e-05, -1.3995757614655028e-06, 0.0007000338824547783],
    [2.6999657812092412e-05, 6.84125655886088e-05, 0.0001091747701148169],
]
ATTITUDES = [
    [
        [0.027390051586171922, 0.9788250877467233, 0.20285766604188066],
        [-0.9931696714363302, 0.0496720541925464, -0.10557788959619004],
        [-0.113418644029115, -0.19858029768875596, 0.9734999109175382],
    ],
    [
        [0.40223261279274813, -0.8666987177509369, 0.29502924915169654],
        [0.9096656765280227, 0.3418955924488843, -0.23582994044680214],
        [0.10352430706404854, 0.3632364746459835, 0.9259276328816366],
    ],
]


def test_two_octahedra_move_as_in_gubas(tmp_path):
    shutil.copy(DATA / "peers" / "gubas_octahedra.cfg", tmp_path / "pair.cfg")
    for name, axes in (("Primary", (900.0, 800.0, 700.0)), ("Secondary", (260.0, 210.0, 160.0))):
        solid = octahedron(*axes)
        rows = [f"0,{x!r},{y!r},{z!r}\n" for x, y, z in solid.vertices.tolist()]
        (tmp_path / f"{name}_vertices.csv").write_text("".join(rows))
        (tmp_path / f"{name}_faces.csv").write_text("".join(f"{i + 1},{j + 1},{k + 1},,\n" for i, j, k in solid.faces))
    original, state = fullbody.read_gubas(tmp_path / "pair.cfg", euler="radian")

    def end(gravity):
        system = fullbody.System(original.bodies, G=original.G, gravity=gravity, gravity_tolerance=1e-9)
        return system.integrate(state, TIME, output=[TIME], integrator=fullbody.Verner98(1e-12, 1e-12))[-1]

    same = end("multipole:4")
    close(same.position[1] - same.position[0], SEPARATION, 1e-11)
    close(same.velocity[1] - same.velocity[0], VELOCITY, 1e-11)
    close(same.spin, SPINS, 1e-11)
    close(same.rotation_matrix, ATTITUDES, 1e-11)
    # The truncation shifts the secondary by a quarter of a metre in two hours and rotates it by 0.001 revolutions.
    exact = end("focal")
    left_out = np.linalg.norm(exact.position[1] - exact.position[0] - SEPARATION)
    assert 2.5e-4 < left_out < 2.7e-4
