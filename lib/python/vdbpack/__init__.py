"""Dense packs of spheres that do not overlap, in bone: numpy in, numpy out.

    import vdbpack
    pack = vdbpack.pack("femur.stl", radius=vdbpack.uniform(1, 2), shell=3)
    pack.positions, pack.radii      # (N, 3) and (N,), float64, mm, read-only

Functions take the options of the command line with underscores for dashes. Lengths are mm.
"""

try:
    from . import _core as _core
except ImportError as _error:
    from importlib.util import find_spec as _find_spec
    if _find_spec(__name__ + "._core") is None:
        raise ImportError(
            "the C++ part of vdbpack is not built: cmake --build --preset release --target vdbpack_python takes half a "
            "minute; then set PYTHONPATH=build/release/lib/python"
        ) from _error
    raise

from ._commands import (
    carve, convert, densify, inspect_image, inspect_mesh, measure, morphometry, pack, predict, repair, stiffness, verify,
    voids,
)
from ._core import __version__
from ._domains import Image, LevelSet, Mesh, Shape, ball, box, cylinder, disc, image, level_set, rect
from ._errors import Error, FileError, InputError, ParameterError, ResourceError, VdbpackWarning
from ._pack import Pack, Report, Voids, read, read_points, write, write_points
from ._sizes import Sizes, constant, lognormal, normal, table, uniform

__all__ = [
    "Error", "FileError", "Image", "InputError", "LevelSet", "Mesh", "Pack", "ParameterError", "Report",
    "ResourceError", "Shape", "Sizes", "VdbpackWarning", "Voids", "__version__", "ball", "box", "carve", "constant",
    "convert", "cylinder", "densify", "disc", "image", "inspect_image", "inspect_mesh", "level_set", "lognormal",
    "measure", "morphometry", "normal", "pack", "predict", "read", "read_points", "rect", "repair", "stiffness",
    "table", "uniform", "verify", "voids", "write", "write_points",
]
