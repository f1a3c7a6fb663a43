import os
import pathlib

import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def program():
    """The command line's program, of the same build."""
    return os.environ.get("VDB_PACK", str(ROOT / "build/release/tools/vdb_pack"))


@pytest.fixture
def femur():
    return ROOT / "assets/meshes/femur.ply"


def cube(side=10.0, shift=(0.0, 0.0, 0.0)):
    """(vertices, faces) of a closed cube."""
    corners = numpy.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    faces = numpy.array(
        [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2],
         [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    )
    return side * corners + numpy.array(shift), faces


def write_off(file, mesh):
    """Writes (vertices, faces) as a mesh file."""
    rows = [f"{x} {y} {z}" for x, y, z in mesh[0]] + [f"3 {a} {b} {c}" for a, b, c in mesh[1]]
    file.write_text("\n".join(["OFF", f"{len(mesh[0])} {len(mesh[1])} 0", *rows, ""]))
