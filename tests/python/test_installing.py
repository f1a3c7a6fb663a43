"""Where the module is installed, and what pyproject.toml says."""

import os
import re
import subprocess
import sys

import pytest
from conftest import ROOT


def test_installed_module(tmp_path):
    build = os.environ.get("VDBPACK_BUILD")
    if not build:
        pytest.skip("VDBPACK_BUILD does not name a build folder")
    subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", tmp_path], check=True,
                   capture_output=True)
    packages = [path.parent for path in tmp_path.rglob("vdbpack") if path.is_dir()]
    assert len(packages) == 1
    # Of /usr/local, it is where this Python looks.
    if sys.executable == "/usr/bin/python3":
        inside = packages[0].relative_to(tmp_path)
        assert f"/usr/local/{inside}" in sys.path
    code = "import vdbpack; print(vdbpack.__file__, len(vdbpack.pack(vdbpack.ball(4), radius=1)) > 20)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path,
                          env={**os.environ, "PYTHONPATH": str(packages[0])}).stdout
    assert said.startswith(str(packages[0])) and said.endswith("True\n")
    assert (packages[0] / "vdbpack/py.typed").is_file() and all((packages[0] / f"vdbpack/{stub}.pyi").is_file() for stub in ("_core", "_commands"))


def test_pyproject():
    tomllib = pytest.importorskip("tomllib")
    with open(ROOT / "pyproject.toml", "rb") as file:
        project = tomllib.load(file)
    made = (ROOT / "CMakeLists.txt").read_text() + (ROOT / "lib/python/CMakeLists.txt").read_text()
    build = project["tool"]["scikit-build"]
    for option in build["cmake"]["define"]:
        assert option in made, option
    for target in build["build"]["targets"]:
        assert f"({target} " in made, target
    for component in build["install"]["components"]:
        assert f"COMPONENT {component}" in made, component
    version = re.search(build["metadata"]["version"]["regex"], (ROOT / "CMakeLists.txt").read_text())
    assert re.fullmatch(r"[0-9.]+", version["value"])
    import vdbpack

    assert vdbpack.__version__ == version["value"]
