"""The recipes of the guide run as they stand, and their types are right."""

import os
import pathlib
import re
import subprocess
import sys

import pytest
from conftest import ROOT

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


def test_types(tmp_path):
    pytest.importorskip("mypy")
    files = []
    for k, (_, code) in enumerate(RECIPES):
        files.append(tmp_path / f"recipe{k}.py")
        files[-1].write_text(code)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", "--cache-dir", tmp_path / "cache",
         *files, ROOT / "lib/python/vdbpack"],
        capture_output=True, text=True, env={**os.environ, "MYPYPATH": str(ROOT / "lib/python")}, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_stub_names_what_there_is():
    import vdbpack._core as core

    stub = (pathlib.Path(ROOT) / "lib/python/vdbpack/_core.pyi").read_text()
    names = set(re.findall(r"^(?:def|class) (\w+)", stub, re.M))
    assert names == {n for n in dir(core) if not n.startswith("__")}


def test_api_page_is_that_of_the_docstrings():
    import api_page

    import vdbpack

    listed = [name for names in api_page.GROUPS.values() for name in names]
    assert sorted(listed) == sorted(n for n in vdbpack.__all__ if not n.startswith("__"))
    assert (ROOT / "assets/guides/python-api.md").read_text(encoding="utf-8") == api_page.page()
