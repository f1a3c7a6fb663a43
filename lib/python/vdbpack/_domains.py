"""Domains: shapes, meshes and images, as files or in memory."""

from __future__ import annotations

import html
import os
from importlib import import_module, util
from typing import Any, Optional, Tuple, Union

import numpy
import numpy.typing

from . import _core
from ._errors import ParameterError

__all__ = ["Shape", "Image", "LevelSet", "Mesh", "Domain", "level_set", "box", "ball", "cylinder", "rect", "disc", "image"]

Array = numpy.typing.NDArray[Any]
_COMMANDS = tuple(command for command, _, _ in _core.options())


def plain(values: Any, name: str) -> Any:
    """Values as they are; masks and imaginary parts would be lost."""
    if isinstance(values, numpy.ma.MaskedArray) and numpy.any(values.mask):
        raise ParameterError(f"{name}: has masked values; fill them, or select what is not masked")
    if numpy.iscomplexobj(values):
        raise ParameterError(f"{name}: has complex numbers; give real ones")
    return values


def number_array(values: Any, name: str) -> Array:
    """Values as an array of real numbers, unmasked."""
    try:
        array = numpy.asarray(plain(values, name))
    except ValueError as error:
        raise ParameterError(f"{name}: rows of one length are needed: {error}") from None
    if array.dtype.kind not in "iuf":
        raise ParameterError(f"{name}: has values of type {array.dtype}; numbers are needed")
    return array


def file_word(file: Any) -> str:
    """A file as a word that is neither an option nor a command."""
    text = os.fsdecode(file)
    return os.path.join(".", text) if text.startswith("-") or text in _COMMANDS else text


class Shape(str):
    """A shape about the origin, as the command line writes it."""


class Image:
    """A label map or grey image in memory.

    values: array of shape (X, Y, Z), numbers of up to 32 bits or floats.
    affine: array of shape (4, 4), from indices to mm.
    space: "ras" as in NIfTI and nibabel, or "lps" as in DICOM and ITK: the world of `affine`.
    """

    def __init__(self, values: Array, affine: Array, space: str = "ras") -> None:
        if space not in ("ras", "lps"):
            raise ParameterError(f"space {space!r}: is either 'ras' or 'lps'")
        self.values = numpy.asarray(plain(values, "image"))
        if self.values.ndim == 4 and self.values.shape[3] == 1:
            self.values = self.values[..., 0]
        if self.values.ndim != 3:
            raise ParameterError(f"image: has shape {self.values.shape}; three dimensions are needed")
        self.affine = number_array(affine, "affine").astype(float)
        if self.affine.shape != (4, 4):
            raise ParameterError(f"affine: has shape {self.affine.shape}, not (4, 4)")
        if not numpy.isfinite(self.affine).all() or self.affine[3].tolist() != [0, 0, 0, 1]:
            raise ParameterError(f"affine: its numbers must be finite and its last row 0, 0, 0, 1: {self.affine.tolist()}")
        if space == "ras":
            self.affine[:2] *= -1

    def __repr__(self) -> str:
        return f"vdbpack.Image of {' x '.join(map(str, numpy.shape(self.values)))} voxels"


class LevelSet:
    """Signed distances as an array: see `level_set`."""

    def __init__(self, values: Any, spacing: float, origin: Any) -> None:
        self.values = number_array(values, "level set")
        if self.values.ndim != 3:
            raise ParameterError(f"level set: has shape {self.values.shape}; three dimensions are needed")
        if numpy.ndim(spacing) != 0 or not float(spacing) > 0:
            raise ParameterError(f"spacing: is {spacing}; one positive number is needed, mm")
        self.spacing = float(spacing)
        self.origin = tuple(float(c) for c in number_array(origin, "origin").ravel())
        if len(self.origin) != 3:
            raise ParameterError(f"origin: has {len(self.origin)} coordinates, not 3")

    def to_pyopenvdb(self) -> Any:
        """The same as a FloatGrid of OpenVDB, a level set with a band of three points; mm."""
        openvdb = import_module("openvdb" if util.find_spec("openvdb") else "pyopenvdb")  # until version 10
        grid = openvdb.FloatGrid(3 * self.spacing)
        grid.copyFromArray(numpy.clip(self.values, -3 * self.spacing, 3 * self.spacing).astype("f4"))
        rows = [[self.spacing * (i == j) for j in range(3)] + [0] for i in range(3)]
        grid.transform = openvdb.createLinearTransform([*rows, [*self.origin, 1]])
        grid.gridClass = openvdb.GridClass.LEVEL_SET
        grid.signedFloodFill()
        return grid

    def __repr__(self) -> str:
        return f"vdbpack.LevelSet of {' x '.join(map(str, self.values.shape))} points, {self.spacing:g} mm apart"


class Mesh:
    """A surface of triangles. A domain as well.

    vertices: float64 of shape (N, 3), mm. faces: int64 of shape (M, 3), counter-clockwise from outside.
    report: the health of it, or what a repair did.
    """

    def __init__(self, vertices: Array, faces: Array, report: Any = None) -> None:
        self.vertices = vertices
        self.faces = faces
        self.report = report

    def __repr__(self) -> str:
        return f"<vdbpack.Mesh of {len(self.vertices):,} vertices and {len(self.faces):,} faces>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}\n{html.escape(str(self.report or ''))}</pre>"


Domain = Union[str, "os.PathLike[str]", Tuple[Any, Any], Image, Any]


def box(*lengths: float) -> Shape:
    """A box: three lengths, centered at the origin, or x0, y0, z0, x1, y1, z1; mm."""
    if len(lengths) not in (3, 6):
        raise ParameterError(f"box: takes 3 or 6 numbers, not {len(lengths)}")
    return Shape("box:" + ",".join(map(repr, map(float, lengths))))


def ball(radius: float) -> Shape:
    """A ball about the origin; mm."""
    return Shape(f"ball:{float(radius)!r}")


def cylinder(radius: float, height: float) -> Shape:
    """A cylinder along z, centered at the origin; mm."""
    return Shape(f"cylinder:{float(radius)!r},{float(height)!r}")


def rect(*lengths: float) -> Shape:
    """A rectangle for circles: two lengths, centered at the origin, or x0, y0, x1, y1; mm."""
    if len(lengths) not in (2, 4):
        raise ParameterError(f"rect: takes 2 or 4 numbers, not {len(lengths)}")
    return Shape("rect:" + ",".join(map(repr, map(float, lengths))))


def disc(radius: float) -> Shape:
    """A disc for circles, about the origin; mm."""
    return Shape(f"disc:{float(radius)!r}")


def image(values: Array, affine: Array, space: str = "ras") -> Image:
    """A label map or grey image in memory. Those of nibabel are domains as they are.

    values: array of shape (X, Y, Z). affine: (4, 4), from indices to mm.
    space: "ras" (NIfTI, nibabel) or "lps" (DICOM, ITK), the world of `affine`. Packs lie in LPS,
    unless `space="ras"` is given to the command as well.
    """
    return Image(numpy.asanyarray(values), affine, space)


def level_set(
    values: numpy.typing.ArrayLike, spacing: float, origin: Tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> LevelSet:
    """A solid by its signed distances at the points of a lattice, negative inside; mm.

    values: array of shape (X, Y, Z), positive at its border. spacing: between points, mm.
    origin: of the first point, mm.
    """
    return LevelSet(values, spacing, origin)


def domain_words(domain: Domain) -> Tuple[str, dict[str, Any]]:
    """A domain as a word of the command line, and its arrays if it has any."""
    if isinstance(domain, (str, os.PathLike)):
        return file_word(domain), {}
    if hasattr(domain, "dataobj") and hasattr(domain, "affine"):
        domain = nibabel_image(domain)
    if isinstance(domain, Image):
        return "(image)", {"image": (domain.values, domain.affine)}
    if hasattr(domain, "copyToArray") and hasattr(domain, "evalActiveVoxelBoundingBox"):
        domain = grid_level_set(domain)
    if isinstance(domain, LevelSet):
        return "(level set)", {"level_set": (domain.values, domain.spacing, domain.origin)}
    mesh = mesh_arrays(domain)
    if mesh is None:
        raise ParameterError(
            f"domain: {type(domain).__name__} is no domain; give a file name, a shape, (vertices, faces), "
            "a mesh with .vertices and .faces, an image or a level set"
        )
    vertices, faces = mesh
    return "(mesh)", {"mesh": (number_array(vertices, "vertices"), number_array(faces, "faces"))}


def nibabel_image(given: Any) -> Image:
    """An image of nibabel, in mm."""
    if given.affine is None:
        raise ParameterError("domain: the image has no affine; give vdbpack.image(values, affine), mm")
    affine = numpy.array(given.affine, float)
    units = getattr(getattr(given, "header", None), "get_xyzt_units", None)
    unit = units()[0] if units else "mm"
    affine[:3] *= {"micron": 0.001, "meter": 1000.0}.get(unit, 1.0)
    return Image(numpy.asanyarray(given.dataobj), affine)


def grid_level_set(grid: Any) -> LevelSet:
    """A level set of pyopenvdb, whose lengths are mm, with one point around its band."""
    low, high = grid.evalActiveVoxelBoundingBox()
    low = tuple(c - 1 for c in low)
    values = numpy.empty([h - l + 2 for l, h in zip(low, high)], "f4")
    grid.copyToArray(values, ijk=low)
    spacing = grid.transform.voxelSize()
    if not numpy.allclose(spacing, spacing[0]):
        raise ParameterError(f"domain: its voxels are {spacing} mm; cubes are needed")
    return LevelSet(values, spacing[0], grid.transform.indexToWorld(low))


def mesh_arrays(domain: Any) -> Optional[Tuple[Any, Any]]:
    """(vertices, faces) of a tuple, of trimesh or of meshio; None for anything else."""
    if isinstance(domain, (tuple, list)) and len(domain) == 2:
        return domain[0], domain[1]
    if hasattr(domain, "vertices") and hasattr(domain, "faces"):
        return domain.vertices, domain.faces
    if hasattr(domain, "points") and hasattr(domain, "cells_dict"):  # meshio
        triangles = domain.cells_dict.get("triangle")
        if triangles is not None:
            return domain.points, triangles
    return None
