"""Packs and reports."""

from __future__ import annotations

import base64
import html
import json
import os
from types import MappingProxyType
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy
import numpy.typing

from . import _core
from ._domains import LevelSet, number_array, plain
from ._errors import ParameterError

__all__ = ["Pack", "Report", "Voids", "read", "write", "read_points", "write_points"]

Floats = numpy.typing.NDArray[numpy.float64]
Path = Union[str, "os.PathLike[str]"]
_ATTRIBUTES = ("id", "region", "order", "depth", "contacts")


class Report(Dict[str, Any]):
    """The report of a run: the fields that `--json` prints, lengths in mm. `print` shows a summary.

    passed: whether no check failed. failures: what failed, as text.
    """

    passed: bool
    summary: str
    failures: str

    def __init__(self, text: str = "{}", summary: str = "", passed: bool = True, failures: str = "") -> None:
        super().__init__(json.loads(text))
        self.summary = summary
        self.passed = passed
        self.failures = failures

    def __str__(self) -> str:
        return self.summary.rstrip() or super().__str__()

    def __reduce__(self) -> Tuple[Any, ...]:
        return Report, (json.dumps(dict(self)), self.summary, self.passed, self.failures)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.summary)}</pre>"


def _column(name: str, values: Any) -> Any:
    """A column as an array of numbers or a list of texts."""
    listed = values.tolist() if isinstance(values, numpy.ndarray) and values.dtype.kind in "UO" else values
    if isinstance(listed, (list, tuple)) and any(isinstance(value, str) for value in listed):
        if not all(isinstance(value, str) for value in listed):
            raise ParameterError(f"{name}: has texts and other values; give texts alone, or numbers alone")
        return list(listed)
    if numpy.asarray(plain(values, name)).dtype.kind == "b":
        return numpy.asarray(values).astype(int)
    return number_array(values, name)


class Pack:
    """Spheres (or circles), with what is known of each. Lengths in mm; arrays are read-only.

    Pack(positions, radii, **columns) makes one from arrays: positions of shape (N, 3), or (N, 2)
    for circles; radii of shape (N,); columns of numbers of shape (N,) or lists of N texts. Of them,
    `id`, `region`, `order`, `depth` and `contacts` have a meaning of their own; part_names are
    texts by the numbers in a column `part`.
    """

    report: Optional[Report]
    picture: Optional[bytes]

    def __init__(
        self,
        positions: numpy.typing.ArrayLike,
        radii: numpy.typing.ArrayLike,
        *,
        part_names: Optional[List[str]] = None,
        **columns: Any,
    ) -> None:
        for name in ("x", "y", "z", "radius", "positions", "radii"):
            if name in columns:
                raise ParameterError(f"{name}: is no further column, but that of the spheres themselves")
        centers = number_array(positions, "positions")
        if centers.ndim != 2 or centers.shape[1] not in (2, 3):
            raise ParameterError(f"positions: have shape {centers.shape}; (N, 3), or (N, 2) for circles, is needed")
        given = {name: _column(name, values) for name, values in columns.items() if values is not None}
        data = _core.PackData(centers, number_array(radii, "radii"), given)
        if part_names:
            if "part" not in given:
                raise ParameterError("part_names: there is no column part that they name; give it too")
            data.part_names = list(part_names)
        self._take(data)

    @classmethod
    def _of(
        cls, data: _core.PackData, report: Optional[Report] = None, picture: bytes = b""
    ) -> Pack:
        pack = cls.__new__(cls)
        pack._take(data, report, picture)
        return pack

    def _take(
        self, data: _core.PackData, report: Optional[Report] = None, picture: bytes = b""
    ) -> None:
        self._data = data
        self._columns = data.columns
        self.report = report
        self.picture = picture or None

    @property
    def positions(self) -> Floats:
        """Centers, float64 of shape (N, 3), or (N, 2) for circles; mm. A view with strides, read-only."""
        return self._data.positions

    @property
    def radii(self) -> Floats:
        """Radii, float64 of shape (N,); mm."""
        return self._data.radii

    @property
    def id(self) -> numpy.typing.NDArray[numpy.int64]:
        """Names of the spheres, int64 of shape (N,): 0, 1, 2, ... unless a file says otherwise."""
        given = self._columns.get("id")
        ids: numpy.typing.NDArray[numpy.int64] = numpy.arange(len(self)) if given is None else given
        return ids

    @property
    def region(self) -> Optional[numpy.typing.NDArray[numpy.int32]]:
        """0 cortical, 1 trabecular, int32 of shape (N,); None where it is unknown."""
        return self._columns.get("region")

    @property
    def order(self) -> Optional[numpy.typing.NDArray[numpy.int64]]:
        """When each sphere was placed, int64 of shape (N,); None where it is unknown."""
        return self._columns.get("order")

    @property
    def depth(self) -> Optional[numpy.typing.NDArray[numpy.float32]]:
        """Distance of each center to the wall, float32 of shape (N,), mm; None where it is unknown."""
        return self._columns.get("depth")

    @property
    def contacts(self) -> Optional[numpy.typing.NDArray[numpy.int32]]:
        """Spheres and walls in contact, int32 of shape (N,); None where it is unknown."""
        return self._columns.get("contacts")

    @property
    def part_names(self) -> List[str]:
        """Names of the parts by the numbers in `columns["part"]`; empty where a pack has none."""
        return self._data.part_names

    def pairs(
        self, tolerance: float = 1e-3
    ) -> Tuple[numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64]]:
        """Spheres in contact, across the faces of a periodic cell as well.

        tolerance: largest gap, as a share of the smaller radius.

        Returns the indices (i, j) of each pair, i < j, int64 of shape (M, 2) and sorted, and the gaps, float64
        of shape (M,), mm; they are negative where spheres overlap. Raises ParameterError for a tolerance
        below 0.
        """
        return self._data.pairs(tolerance)

    @property
    def columns(self) -> Mapping[str, Any]:
        """All further columns by name: float64 of shape (N,), or lists of N texts."""
        return MappingProxyType({k: v for k, v in self._columns.items() if k not in _ATTRIBUTES})

    @property
    def hash(self) -> str:
        """The hash of centers and radii, as reports have it; the same in any order."""
        return self._data.hash

    @property
    def slice_height(self) -> Optional[float]:
        """Of circles: the height of their plane, mm; None for spheres."""
        return self._data.slice_height

    def __len__(self) -> int:
        return len(self.radii)

    def __repr__(self) -> str:
        kind = "circles" if self.positions.shape[1] == 2 else "spheres"
        if len(self) == 0:
            return f"<vdbpack.Pack without {kind}>"
        text = f"<vdbpack.Pack of {len(self):,} {kind}, radii {self.radii.min():.4g} to {self.radii.max():.4g} mm"
        solid = self.report.get("solidFraction", {}).get("total") if self.report else None
        return text + (f", solid fraction {solid:.4f}>" if solid else ">")

    def _repr_html_(self) -> str:
        text = self.report.summary if self.report else repr(self)
        shown = f"<pre>{html.escape(text)}</pre>"
        if self.picture:
            data = base64.b64encode(self.picture).decode()
            shown = f'<img alt="the pack" style="max-width: 480px" src="data:image/png;base64,{data}">' + shown
        return shown

    def __reduce__(self) -> Tuple[Any, ...]:
        columns = {k: numpy.array(v) if isinstance(v, numpy.ndarray) else v for k, v in self._columns.items()}
        state = {
            "report": self.report,
            "picture": self.picture,
            "slice_height": self.slice_height,
            "part_names": self.part_names,
        }
        return _rebuilt, (numpy.array(self.positions), numpy.array(self.radii), columns, state)

    def write(self, file: Path, unit: str = "mm") -> None:
        """Writes the pack; see `write`."""
        write(self, file, unit)

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame: id, x, y, z (mm), radius (mm), and all columns; a row a sphere."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_dataframe needs pandas: pip install pandas, or python3-pandas of Debian") from error

        table: Dict[str, Any] = {"id": self.id}
        for d, axis in enumerate("xyz"[: self.positions.shape[1]]):
            table[axis] = self.positions[:, d]
        table["radius"] = self.radii
        table.update({k: v for k, v in self._columns.items() if k != "id"})
        return pandas.DataFrame(table)

    def to_vtk(self) -> Any:
        """A vtkPolyData with a vertex a sphere; point data: radius (mm) and all columns of numbers.

        Its coordinates are a copy. Circles lie at their height.
        """
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

        count = len(self)
        centers = numpy.zeros((count, 3))
        centers[:, : self.positions.shape[1]] = self.positions
        if self.slice_height is not None:
            centers[:, 2] = self.slice_height
        points, vertices, data = vtkPoints(), vtkCellArray(), vtkPolyData()
        points.SetData(numpy_to_vtk(centers, deep=True))
        vertices.SetData(1, numpy_to_vtk(numpy.arange(count), deep=True))
        data.SetPoints(points)
        data.SetVerts(vertices)
        arrays = {"radius": self.radii, "id": self.id, **self._columns}
        for name, values in arrays.items():
            if isinstance(values, numpy.ndarray):
                array = numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
                array.SetName(name)
                data.GetPointData().AddArray(array)
        data.GetPointData().SetActiveScalars("radius")
        return data

    def to_pyvista(self) -> Any:
        """The same as a pyvista.PolyData."""
        import pyvista

        return pyvista.wrap(self.to_vtk())

    def to_yade(self, **attributes: Any) -> Any:
        """Bodies for a YADE session, `O.bodies.append(pack.to_yade())`; lengths stay mm unless scaled.

        attributes: those of `yade.utils.sphere`, such as material; scale=0.001 gives meters.
        """
        from yade import utils

        scale = float(attributes.pop("scale", 1.0))
        centers = numpy.full((len(self), 3), self.slice_height or 0.0)
        centers[:, : self.positions.shape[1]] = self.positions
        rows: Any = (scale * numpy.column_stack([centers, self.radii])).tolist()
        return [utils.sphere((x, y, z), radius, **attributes) for x, y, z, radius in rows]


class Voids:
    """Voids in a domain and what they leave; lengths in mm.

    report: a `Report`. centers: float64 of shape (M, 3), 2D (M, 2). half_axes: float64 of shape
    (M, 2), a along the axis and b across it. axes: unit vectors along a, of the shape of centers.
    """

    def __init__(self, report: Report, arrays: Tuple[Floats, Floats, Floats], sets: Mapping[str, Any]) -> None:
        self.report = report
        self.centers, self.half_axes, self.axes = arrays
        self._sets = sets

    @property
    def solid(self) -> Optional[LevelSet]:
        """What the voids leave, as signed distances in an array, a copy each time; None in 2D."""
        return self._level_set("solid")

    @property
    def surface(self) -> Optional[LevelSet]:
        """The domain, as signed distances in an array; None in 2D."""
        return self._level_set("surface")

    def _level_set(self, name: str) -> Optional[LevelSet]:
        held = self._sets.get(name)
        return held if held is None or isinstance(held, LevelSet) else LevelSet(*held.array())

    def __reduce__(self) -> Tuple[Any, ...]:
        sets = {name: self._level_set(name) for name in self._sets}
        return Voids, (self.report, (self.centers, self.half_axes, self.axes), sets)

    def __len__(self) -> int:
        return len(self.centers)

    def __repr__(self) -> str:
        bvtv = self.report["voids"]["bvtv"]
        return f"<vdbpack.Voids: {len(self):,}" + (f", BV/TV {bvtv:.4f}>" if bvtv is not None else ">")

    def _repr_html_(self) -> str:
        return self.report._repr_html_()


def _rebuilt(positions: Floats, radii: Floats, columns: Dict[str, Any], state: Dict[str, Any]) -> Pack:
    data = _core.PackData(positions, radii, columns, state["slice_height"] or 0.0)
    data.part_names = state["part_names"]
    return Pack._of(data, state["report"], state["picture"] or b"")


def read(file: Path, unit: str = "mm", grid: str = "", columns: str = "", pack_radius: float = 0) -> Pack:
    """Reads a pack of any program: .vdb .csv .vtp .ply .xyz .npz .vtkhdf, LAMMPS, LIGGGHTS, YADE.

    unit: of the file, if it does not state its own: "m", "cm", "mm" or "um". grid: of a .vdb.
    columns: of a file: all names, "x,y,z,r", or new names of some, "x=East,y=North".
    pack_radius: mm, of spheres in a file without radii.

    Files do not say whether spheres are circles of a plane: these come back as spheres, positions of shape
    (N, 3). Runs in a domain of the plane take them as circles again.
    """
    return Pack._of(_core.read(os.fsdecode(file), unit, grid, columns, pack_radius))


def write(pack: Pack, file: Path, unit: str = "mm") -> None:
    """Writes a pack; the format by extension or prefix ("yade:pack.txt"). unit: of the file."""
    if not isinstance(pack, Pack):
        raise ParameterError(f"pack: {type(pack).__name__} is no vdbpack.Pack")
    name = os.fsdecode(file)
    if not isinstance(unit, str):
        raise ParameterError(f"unit: {type(unit).__name__} is no unit; give m, cm, mm or um")
    _core.write(pack._data, name, unit)


def read_points(file: Path, grid: str = "") -> Pack:
    """Reads a grid of points with radii (`pscale`) from a .vdb. grid: its name; the first if empty.

    The points come by rising id.
    """
    return read(_vdb(file), grid=grid)


def write_points(
    file: Path,
    points: Union[Pack, numpy.typing.ArrayLike],
    radii: Optional[numpy.typing.ArrayLike] = None,
    unit: str = "mm",
    **columns: Any,
) -> None:
    """Writes a grid of points with radii (`pscale`) and columns, alone in a .vdb.

    points: a `Pack`, or positions of shape (N, 3) with radii of shape (N,) and columns as for `Pack`; mm.
    unit: of the file.

    Radii are stored as float32, positions to 2^-25 of a voxel of the grid, which has some points: exactly
    for packs of `pack`, otherwise to about 1e-7 of their distances.
    """
    name = _vdb(file)
    if not isinstance(points, Pack):
        if radii is None:
            raise ParameterError("radii: is missing; points are written with their radii")
        points = Pack(points, radii, **columns)
    elif radii is not None or columns:
        raise ParameterError(f"{'radii' if radii is not None else next(iter(columns))}: the pack has its own columns")
    write(points, "points:" + name, unit)


def _vdb(file: Path) -> str:
    name = os.fsdecode(file)
    if not name.lower().endswith(".vdb"):
        raise ParameterError(f"file {name}: grids of points are .vdb; `read` and `write` know other formats")
    return name
