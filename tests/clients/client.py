"""What the checks with other programs share: installing, packing, reading, telling."""

import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
VDB_PACK = os.environ.get("VDB_PACK", str(ROOT / "build/release/tools/vdb_pack"))
MESHES = ROOT / "assets/meshes"


def needs(*packages):
    """Installs Debian packages, as far as they are missing."""
    subprocess.run([ROOT / "tools/install-dependencies", *packages], check=True)


class Failed(Exception):
    """The client does not get what was written."""


def require(condition, message):
    if not condition:
        raise Failed(message)


def require_close(what, found, expected, tolerance):
    """Two numbers, or two rows of numbers, that differ by `tolerance` at most."""
    found, expected = (list(v) if hasattr(v, "__len__") else [v] for v in (found, expected))
    require(len(found) == len(expected), f"{what}: {len(found)} values, not {len(expected)}")
    worst = max((abs(a - b) if math.isfinite(a) else math.inf for a, b in zip(found, expected)),
                default=0.0)
    require(worst <= tolerance, f"{what}: off by {worst:g}, more than {tolerance:g}")
    return worst


def run(*command, fails=False, **options):
    """What a program prints, both streams. It must succeed, or fail if it should."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace",
                          timeout=options.pop("timeout", 300), **options)
    if (done.returncode != 0) != fails:
        raise Failed(f"{command[0]} ended with {done.returncode}:\n" + done.stdout[-3000:])
    return done.stdout


def run_on_display(*command, **options):
    """The same on an X server of its own. Two that look for a free number at once take the same."""
    number = 1000 + os.getpid() % 30000
    return run("xvfb-run", "-n", number, "-s", "-screen 0 1280x1024x24", *command, **options)


def vdb_pack(*arguments, **options):
    return run(VDB_PACK, *arguments, **options)


def python_module():
    """The module `vdbpack` of the build folder."""
    sys.path.insert(0, os.environ.get("VDBPACK_PYTHON", str(ROOT / "build/release/lib/python")))
    import vdbpack

    return vdbpack


def columns(path):
    """A .csv as {name: numbers}."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = next(rows)
        return dict(zip(names, map(list, zip(*([float(c) for c in row] for row in rows)))))


def check(work):
    """Calls `work(folder)` with a folder of its own; exit code 1 and the reason if it fails."""
    with tempfile.TemporaryDirectory(prefix="vdbpack-") as folder:
        try:
            work(pathlib.Path(folder))
        except Failed as problem:
            sys.exit(f"FAILED: {problem}")
