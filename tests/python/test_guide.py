"""The recipes of the guide run as they stand, and their types are right."""

import os
import pathlib
import re
import subprocess
import sys

import pytest
from conftest import ROOT

import vdbpack

GUIDE = (ROOT / "assets/guides/python.md").read_text(encoding="utf-8")
RECIPES = re.findall(r"^## (\d+\. [^\n]*)\n.*?```python\n(.*?)```", GUIDE, re.S | re.M)


def test_there_are_ten():
    assert len(RECIPES) == 10


@pytest.mark.parametrize("name, code", RECIPES, ids=[name for name, _ in RECIPES])
def test_recipe(tmp_path, name, code):
    (tmp_path / "recipe.py").write_text(code)
    done = subprocess.run([sys.executable, "recipe.py"], cwd=tmp_path, capture_output=True, text=True)
    for lacking in ("this build reads no images", "No module named 'pandas'"):
        if lacking in done.stderr:
            pytest.skip(lacking)
    assert done.returncode == 0, done.stderr


def wrong_types(tmp_path, *files, package=pathlib.Path(vdbpack.__file__).parents[1]):
    """(file, line) of each error that mypy finds. package: folder of vdbpack, with its stubs."""
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", "--cache-dir", tmp_path / "cache", *files],
        capture_output=True, text=True, env={**os.environ, "MYPYPATH": str(package)}, cwd=tmp_path)
    assert done.returncode < 2, done.stdout + done.stderr
    print(done.stdout)
    return [(pathlib.Path(file).name, int(line)) for file, line in re.findall(r"^(.*):(\d+): error", done.stdout, re.M)]


def test_types_of_the_package(tmp_path):
    assert wrong_types(tmp_path, ROOT / "lib/python/vdbpack", package=ROOT / "lib/python") == []


def test_types_of_keywords(tmp_path):
    files = [tmp_path / f"recipe{k}.py" for k in range(len(RECIPES))]
    for file, (_, code) in zip(files, RECIPES):
        file.write_text(code)
    lines = """import numpy, pathlib, vdbpack
ball = vdbpack.ball(3)
pack = vdbpack.pack(ball, radius=1, effort="dense", gap=None, clip=["a", "b"], label=(1, 2), output=pathlib.Path("a.csv"))
vdbpack.voids(ball, void_axis=numpy.eye(3)[0], shell_from="outer", void_count=3, densify=0.6)  # wrong: an option of pack
vdbpack.pack(ball, raduis=1)  # wrong: misspelled
vdbpack.pack(ball, block_side="40 mm")  # wrong
vdbpack.pack(ball, max_count=2.5)  # wrong
vdbpack.pack(ball, effort="quick")  # wrong
vdbpack.pack(ball, repair="yes")  # wrong
vdbpack.pack(ball, bvtv_field=3)  # wrong
vdbpack.pack(ball, radius=(1, 2))  # wrong
vdbpack.verify(pack, ball, places="many")  # wrong
vdbpack.morphometry(ball, dilation=0.1, preview=True)  # wrong: measure draws no picture
""".splitlines()
    files.append(tmp_path / "calls.py")
    files[-1].write_text("\n".join(lines))
    assert wrong_types(tmp_path, *files) == [("calls.py", k) for k, line in enumerate(lines, 1) if "# wrong" in line]


def test_stub_names_what_there_is():
    import vdbpack._core as core

    stub = (pathlib.Path(ROOT) / "lib/python/vdbpack/_core.pyi").read_text()
    names = set(re.findall(r"^(?:def|class) (\w+)", stub, re.M))
    assert names == {n for n in dir(core) if not n.startswith("__")}


def test_api_page_is_that_of_the_docstrings():
    import api_page

    listed = [name for names in api_page.GROUPS.values() for name in names]
    assert sorted(listed) == sorted(n for n in vdbpack.__all__ if not n.startswith("__"))
    assert (ROOT / "assets/guides/python-api.md").read_text(encoding="utf-8") == api_page.page()


def test_page_of_options_is_that_of_the_table():
    import options_page

    renew = "run tests/python/options_page.py, with PYTHONPATH=build/release/lib/python"
    assert options_page.PAGE.read_text(encoding="utf-8") == options_page.page(), renew
