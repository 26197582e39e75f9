"""``THIRD_PARTY_LICENCES.yml``, which goes with each wheel, lists the crates that the extension contains."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo is not installed")
def test_each_crate_of_the_extension_is_listed_with_its_version():
    command = "cargo tree --locked --offline --package fullbody-python --edges normal --prefix none --format {p}"
    tree = subprocess.run(command.split(), cwd=ROOT, capture_output=True, text=True, check=True).stdout
    linked = {tuple(line.split()[:2]) for line in tree.splitlines()}
    text = (ROOT / "packaging" / "THIRD_PARTY_LICENCES.yml").read_text()
    listed = re.findall(r"^- package_name: (\S+)\n  package_version: '?([^\s']+)", text, re.MULTILINE)
    workspace = {crate for crate in linked if crate[0] in ("fullbody", "fullbody-python")}
    assert len(workspace) == 2
    missing = linked - workspace - {(name, f"v{version}") for name, version in listed}
    assert not missing, f"run `make licences`: {sorted(missing)} are not in THIRD_PARTY_LICENCES.yml"
