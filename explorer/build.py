"""Build the page on which binary asteroids are explored in a browser: ``python explorer/build.py FOLDER``.

The folder gets the page, its script, the core in WebAssembly, and all ready-made systems. It needs the program
wasm-bindgen of the version in Cargo.lock, which ``make explorer`` installs.
"""

from __future__ import annotations

import gzip
import json
import os
import shutil
import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import fullbody
import numpy as np
from fullbody import systems
from fullbody.view.scene import scene_data

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent
TARGET = "wasm32-unknown-unknown"
#: The largest size of the whole page in bytes, compressed by gzip as servers do.
LIMIT = 1_500_000
#: The values of controls with which a system is first shown: Dimorphos begins to roll about its long axis in 400 hours.
FIRST = {"didymos_after_dart": {"tilt of Dimorphos": 0.0573}}
#: The durations of runs in the systems' units of time; those of other systems are 20 periods.
DURATIONS = {"didymos_after_dart": 400.0, "kw4": 200.0, "kw4_ho2021": 200.0, "case1": 200.0, "case2": 200.0}
#: Bodies that impacts hit, and the momenta in kg km/h: DART's (Cheng et al. 2023, Nature 616, 457: 579.4 kg at 6.1449
#: km/s).
IMPACTS = {"didymos": {"body": 1, "momentum": 579.4 * 6.1449 * 3600.0}}
#: The order of the first systems on the page; the others follow by name.
ORDER = ("didymos_after_dart", "kw4", "didymos", "kw4_ho2021")


def described(name: str) -> dict[str, Any]:
    """Return the page's description of a ready-made system, in kilometres, hours and kilograms if it has units."""
    setup = getattr(systems, name)
    system, state = setup()
    core = system.context.core
    arrays = ("position", "velocity", "attitude", "spin")
    description = {
        "bodies": core.bodies,
        "gravitational_constant": system.G,
        "settings": core.settings,
        "forces": core.forces,
        "time": state.time,
        **{key: np.asarray(getattr(state, key)).tolist() for key in arrays},
    }
    orbit = fullbody.KeplerElements.from_cartesian(
        state.position[1] - state.position[0], state.velocity[1] - state.velocity[0], system.mu(1, 0)
    )
    period = 2.0 * np.pi * np.sqrt(float(orbit.a) ** 3 / float(system.mu(1, 0)))
    dimensionless = name.startswith("case")
    shapes = [body.shape for body in system.bodies]
    run = system.integrate(state, state.time + 1e-3 * period)
    surfaces = scene_data(run, flight=None, samples=2, geometry=None)["surfaces"]
    is_ellipsoid = [isinstance(shape, fullbody.Ellipsoid) for shape in shapes]
    return {
        "name": name,
        "title": setup.__doc__.partition("\n")[0].rstrip("."),
        "names": list(system.names),
        "description": description,
        # The page makes the surfaces of ellipsoids from their semi-axes.
        "surfaces": [None if ellipsoid else parts for ellipsoid, parts in zip(is_ellipsoid, surfaces, strict=True)],
        # A light curve of a composite takes too long for a page.
        "lit": all(is_ellipsoid),
        "length": "" if dimensionless else "km",
        "time": "" if dimensionless else "h",
        "mass": "" if dimensionless else "kg",
        "duration": DURATIONS.get(name, float(f"{20.0 * period:.2g}")),
        "impact": IMPACTS.get(name),
        "first": FIRST.get(name),
    }


def script() -> str:
    """Return the page's script as one module: the scene, the sliders, and the part for this page."""
    files = resources.files("fullbody.view")
    parts = [files.joinpath(name).read_text(encoding="utf-8") for name in ("viewer.js", "explorer.js")]
    return "\n".join([*parts, (FOLDER / "site.js").read_text(encoding="utf-8")])


def core(out: Path) -> None:
    """Compile the core with WebAssembly's vector instructions, and write the module with its JavaScript bindings."""
    flags = {f"CARGO_TARGET_{TARGET.upper().replace('-', '_')}_RUSTFLAGS": "-C target-feature=+simd128"}
    environment = {name: value for name, value in os.environ.items() if name != "PYO3_PYTHON"} | flags
    command = ["cargo", "build", "--locked", "--package", "fullbody-web", "--profile", "browser", "--target", TARGET]
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    module = target / TARGET / "browser" / "fullbody_web.wasm"
    options = ["--target", "web", "--no-typescript", "--remove-name-section", "--out-dir", str(out)]
    subprocess.run(["wasm-bindgen", *options, str(module)], check=True)


def main(out: Path) -> None:
    """Build the page, and refuse one that is too large."""
    out.mkdir(parents=True, exist_ok=True)
    core(out)
    names = [name for name in systems.__all__ if name not in ("Published", "Value", "published")]
    names.sort(key=lambda name: (ORDER.index(name) if name in ORDER else len(ORDER), name))
    (out / "systems.json").write_text(json.dumps([described(name) for name in names]), encoding="utf-8")
    (out / "explorer.js").write_text(script(), encoding="utf-8")
    files = resources.files("fullbody.view")
    styles = [files.joinpath(name).read_text(encoding="utf-8") for name in ("viewer.css", "explorer.css")]
    (out / "explorer.css").write_text("".join(styles), encoding="utf-8")
    shutil.copy(FOLDER / "index.html", out / "index.html")
    size = sum(len(gzip.compress(path.read_bytes())) for path in out.iterdir() if path.is_file())
    print(f"{out}: {size / 1000:.0f} kB compressed")
    if size > LIMIT:
        raise SystemExit(f"the page has {size} bytes when compressed; expected at most {LIMIT}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
