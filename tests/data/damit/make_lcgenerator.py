"""Write the files of this folder; the intensities are those of lcgenerator, a program of DAMIT (GPL).

python make_lcgenerator.py SOURCE needs the folder of DAMIT's programs with its light curves of (43) Ariadne,
test_lcs_rel and test_lcs_abs, and lcgenerator built in it (make in its folder lcgenerator).
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent


def curves(path):
    """Yield the lines of each curve of a file."""
    lines = path.read_text().splitlines()[1:]
    while lines:
        count = int(lines[0].split()[0])
        yield lines[: count + 1]
        lines = lines[count + 1 :]


def shape():
    """Return the vertices and faces of an ellipsoid whose long axis is 25 degrees from x, displaced from the origin."""
    rows, meridians = 8, 14
    angles = [(0.0, 0.0)] + [
        (np.pi * i / rows, 2 * np.pi * j / meridians) for i in range(1, rows) for j in range(meridians)
    ]
    angles.append((np.pi, 0.0))
    point = np.array([[np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)] for t, p in angles])
    tilt = np.radians(25.0)
    matrix = np.array([[np.cos(tilt), -np.sin(tilt), 0], [np.sin(tilt), np.cos(tilt), 0], [0, 0, 1]])
    vertices = point * [30.0, 18.0, 14.0] @ matrix.T + [1.0, 2.0, 0.5]
    faces = [(0, 1 + j, 1 + (j + 1) % meridians) for j in range(meridians)]
    for i in range(rows - 2):
        for j in range(meridians):
            a, b = 1 + i * meridians + j, 1 + i * meridians + (j + 1) % meridians
            faces += [(a, a + meridians, b), (b, a + meridians, b + meridians)]
    faces += [
        (len(angles) - 1, len(angles) - 1 - meridians + (j + 1) % meridians, len(angles) - 1 - meridians + j)
        for j in range(meridians)
    ]
    return vertices, np.array(faces) + 1


def main(source):
    relative, calibrated = (list(curves(source / f"test_lcs_{kind}")) for kind in ("rel", "abs"))
    chosen = [relative[k] for k in (1, 9, 20)] + [calibrated[k] for k in (9, 23)]
    text = "\n".join([str(len(chosen)), *(line for curve in chosen for line in curve)]) + "\n"
    (FOLDER / "lc.txt").write_text(text)
    vertices, faces = shape()
    rows = [f"{len(vertices)} {len(faces)}", *(" ".join(f"{x:.6f}" for x in row) for row in vertices)]
    (FOLDER / "shape.txt").write_text("\n".join([*rows, *(" ".join(map(str, row)) for row in faces)]) + "\n")
    (FOLDER / "spin.txt").write_text("253 -15 5.76198\n2438882.0 30.0\n0.5 0.1 -0.5\n0.1\n")
    program = source / "lcgenerator" / "lcgenerator"
    names = [FOLDER / name for name in ("spin.txt", "shape.txt", "lcgenerator.txt")]
    subprocess.run([program, *names], input=text, text=True, check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
