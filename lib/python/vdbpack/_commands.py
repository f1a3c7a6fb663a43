"""The commands of vdb_pack as functions; their keywords come from the rows of lib/vdbpack/options."""

from __future__ import annotations

import numbers
import os
import re
import tempfile
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy

from . import _core
from ._domains import Domain, LevelSet, Mesh, domain_words, file_word
from ._errors import FileError, ParameterError
from ._pack import Pack, Report, Voids
from ._progress import Bar, Progress, progress_of
from ._sizes import Table

__all__ = ["pack", "densify", "carve", "voids", "verify", "measure", "stiffness", "morphometry", "convert", "repair",
           "inspect_mesh", "inspect_image", "predict"]

_TABLE = {command: {option.keyword: option for option in options} for command, _, options in _core.options()}
PackLike = Union[Pack, str, "os.PathLike[str]"]


def _value(name: str, value: Any) -> str:
    """A value as it would stand on the command line."""
    if isinstance(value, (str, bytes, os.PathLike)):
        return os.fsdecode(value)
    if isinstance(value, (bool, numpy.bool_)):
        raise ParameterError(f"{name}: is a flag, which stands alone")
    if isinstance(value, (int, numpy.integer)):
        return str(int(value))
    if isinstance(value, (float, numpy.floating)):
        number = float(value)
        return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    raise ParameterError(f"{name}: {type(value).__name__} is no value of an option")


def _given(command: str, options: Mapping[str, Any], folder: str) -> Tuple[List[Tuple[str, Optional[str]]], List[str]]:
    """Options with their texts, None for flags, and the names of those that are None or False."""
    given: List[Tuple[str, Optional[str]]] = []
    unset: List[str] = []
    for name, value in options.items():
        option = _TABLE[command].get(name)
        if not re.fullmatch("[a-z][a-z0-9_]*", name) or name == "help":
            dashed = name.replace("-", "_")
            hint = f"; did you mean {dashed}?" if dashed in _TABLE[command] else ""
            raise ParameterError(f"{name!r}: is no option{hint}")
        if isinstance(value, numpy.bool_):
            value = bool(value)
        if value is None or value is False:
            unset.append(name)
        elif name == "config" and isinstance(value, (str, os.PathLike)) and not os.path.isfile(value):
            raise FileError(f"{os.fspath(value)}: cannot be read: No such file")
        elif name == "preview" and value is True:
            given.append((name, os.path.join(folder, "preview.png")))
            if options.get("preview_size") is None:  # as notebooks show it
                given.append(("preview_size", "480"))
        elif value is True:
            given.append((name, None))
        elif isinstance(value, Table):
            file = os.path.join(folder, f"{name}.csv")
            with open(file, "w", encoding="utf-8") as table:
                table.write(value.text())
            given.append((name, "table:" + file))
        elif option and option.type == "Radius" and isinstance(value, numbers.Real):
            given.append((name, f"constant:{float(value)!r}"))
        elif option and option.repeats and isinstance(value, (list, tuple)):
            given += [(name, _value(name, one)) for one in value]
        elif isinstance(value, (tuple, list, numpy.ndarray)):
            given.append((name, ",".join(_value(name, one) for one in value)))
        else:
            given.append((name, _value(name, value)))
    return given, unset


def _run(command: str, first: Tuple[str, Dict[str, Any]], options: Mapping[str, Any], progress: Progress,
         domain: Optional[Domain] = None) -> Dict[str, Any]:
    """Runs a command on its first argument, if it has one, and on a domain; both with their arrays."""
    word, inputs = first
    if domain is not None:
        name, arrays = domain_words(domain)
        options, inputs = {"domain": name, **options}, {**inputs, **arrays}
    if any(isinstance(v, Table) for v in options.values()) or options.get("preview") is True:
        inputs["temporary"] = True
    show = progress_of(progress)
    try:
        with tempfile.TemporaryDirectory(prefix="vdbpack-") as folder:
            given, unset = _given(command, options, folder)
            return _core.run([command, word] if word else [command], given, unset, inputs, show)
    finally:
        if isinstance(show, Bar):
            show.close()


def _report(result: Mapping[str, Any]) -> Report:
    return Report(result["report"], result["summary"], result["passed"], result["failures"])


def _packed(result: Mapping[str, Any]) -> Pack:
    return Pack._of(result["pack"], _report(result), result["picture"])


def _pack_word(given: PackLike, name: str = "given") -> Tuple[str, Dict[str, Any]]:
    if isinstance(given, Pack):
        return "(pack)", {"pack": given._data}
    if not isinstance(given, (str, os.PathLike)):
        raise ParameterError(f"{name}: {type(given).__name__} is no pack; give a vdbpack.Pack or a file")
    return file_word(given), {}


def pack(
    domain: Optional[Domain] = None, *, existing: Optional[PackLike] = None, progress: Progress = None, **options: Any
) -> Pack:
    """Fills a domain with spheres (circles in 2D) that do not overlap, and checks the result.

    domain: a file (mesh, level set, image), a shape such as `box(10, 10, 10)`, (vertices, faces) with
        arrays of shape (N, 3) and (M, 3), a mesh of trimesh or meshio, an `image`, a `level_set`, or a
        level set of pyopenvdb. Not with parts="FILE.toml".
    existing: spheres to pack around.
    progress: a callable that takes stage, share and count; True or False; by default a bar where
        there is a terminal or a notebook.
    options: those of `vdb_pack pack`, with underscores for dashes, lengths in mm: radius,
        target_count, densify, shell, voids, seed, output, ... True sets a flag. Lists and tuples repeat an
        option that may be repeated, and are numbers with commas between for others. preview=True draws
        the picture without a file. config="NAME.recipe.toml" repeats a run, with its outputs.

    Raises ParameterError, InputError, FileError, ResourceError; KeyboardInterrupt.
    """
    if options.get("dry_run"):
        raise ParameterError("dry_run: vdbpack.predict takes the same arguments and packs nothing")
    return _packed(_pack_run(domain, existing, progress, options))


def _pack_run(
    domain: Optional[Domain], existing: Optional[PackLike], progress: Progress, options: Mapping[str, Any]
) -> Dict[str, Any]:
    word, inputs = ("", {}) if domain is None else domain_words(domain)
    if isinstance(existing, Pack):
        inputs["existing"] = existing._data
        options = {**options, "existing": "(existing)"}
    elif existing is not None:
        options = {**options, "existing": _pack_word(existing, "existing")[0]}
    return _run("pack", (word, inputs), options, progress)


def densify(given: PackLike, domain: Domain, *, progress: Progress = None, **options: Any) -> Pack:
    """Makes a pack denser within its domain, or removes its overlaps.

    given: a `Pack` or a file. domain, progress: as for `pack`.
    options: those of `vdb_pack densify`: densify ("max" or a solid fraction), gap, seed, ...
    """
    return _packed(_run("densify", _pack_word(given), options, progress, domain))


def carve(given: PackLike, domain: Domain, *, progress: Progress = None, **options: Any) -> Pack:
    """Cuts voids into a pack.

    given: a `Pack` or a file. domain, progress: as for `pack`.
    options: those of `vdb_pack carve`: voids, shell, target_bvtv, void_radius, ...; lengths in mm.
    """
    return _packed(_run("carve", _pack_word(given), options, progress, domain))


def voids(domain: Domain, *, progress: Progress = None, **options: Any) -> Voids:
    """Makes voids in a domain, without spheres.

    domain, progress: as for `pack`. options: those of `vdb_pack voids`; lengths in mm.
    """
    result = _run("voids", domain_words(domain), options, progress)
    return Voids(_report(result), result["voids"], result["level_sets"])


def verify(given: PackLike, domain: Optional[Domain] = None, *, progress: Progress = None, **options: Any) -> Report:
    """Checks any pack for overlaps and, with a domain, for protrusions. `passed` says the result.

    given: a `Pack` or a file. domain, progress: as for `pack`. options: those of `vdb_pack verify`.
    """
    return _report(_run("verify", _pack_word(given), options, progress, domain))


def measure(given: PackLike, domain: Optional[Domain] = None, *, progress: Progress = None, **options: Any) -> Report:
    """Measures a pack (density, contacts, sizes, g(r)), or a solid (morphometry: BV/TV, Tb.Th, ...).

    given: a `Pack`, or a file of a pack or of a solid (.vdb, .stl, ...). domain, progress: as for
    `pack`. options: those of `vdb_pack measure`; lengths in mm.
    """
    return _report(_run("measure", _pack_word(given), options, progress, domain))


def stiffness(given: PackLike, domain: Optional[Domain] = None, *, progress: Progress = None, **options: Any) -> Report:
    """Computes the apparent stiffness of the bonded spheres of a pack.

    given: a `Pack` or a file. domain: that of the pack, whose volume stresses are averaged over; by default
        the box around the spheres, or the periodic cell. progress: as for `pack`.
    options: those of `vdb_pack stiffness`: contact_tol, bond_modulus (MPa), bond_shear, ...

    `["stiffness"]` has six lists of six numbers, MPa, in Voigt's order xx yy zz yz xz xy; `["isotropic"]` has E and nu.
    With press="z", `["pressed"]["modulus"]` is the apparent modulus between two grips, MPa.
    """
    return _report(_run("stiffness", _pack_word(given), options, progress, domain))


def morphometry(solid: Domain, domain: Optional[Domain] = None, *, progress: Progress = None, **options: Any) -> Report:
    """Measures a solid: BV/TV, Tb.Th, Tb.Sp, anisotropy, connectivity; lengths in mm.

    solid: a `level_set`, such as `voids(...).solid`, a mesh, an `image` with its `label` or `threshold`,
        or a file of one of them.
    domain: the total volume; by default the box around the solid, or the image. progress: as for `pack`.
    options: those of `vdb_pack measure`.
    """
    if isinstance(solid, Pack):
        raise ParameterError("solid: a pack is none; measure(pack, morphometry=True) measures its spheres as a solid")
    word, given = domain_words(solid)
    inputs: Dict[str, Any] = {{"level_set": "solid"}.get(name, "solid_" + name): arrays for name, arrays in given.items()}
    return _report(_run("measure", (word, inputs), options, progress, domain))


def convert(given: PackLike, domain: Optional[Domain] = None, *, progress: Progress = None, **options: Any) -> Report:
    """Writes a pack or a solid in other formats (`output`), with columns of grey values if wanted.

    given: a `Pack` or a file. domain, progress: as for `pack`. options: those of `vdb_pack convert`.
    """
    return _report(_run("convert", _pack_word(given), options, progress, domain))


def predict(
    domain: Optional[Domain] = None, *, existing: Optional[PackLike] = None, progress: Progress = None, **options: Any
) -> Report:
    """What `pack` would take with the same arguments: spheres, seconds, memory; packs nothing."""
    return _report(_pack_run(domain, existing, progress, {**options, "dry_run": True}))


def repair(domain: Domain, *, progress: Progress = None, **options: Any) -> Mesh:
    """Closes a mesh, turns its triangles outwards and fuses components that overlap.

    domain: a file, (vertices, faces), or a mesh of trimesh or meshio.
    options: those of `vdb_pack mesh`: output (.stl, mm), unit, repair_voxel (mm), ...

    Returns a `Mesh`, whose `report` says what was wrong and what has been changed.
    """
    result = _run("mesh", domain_words(domain), {"repair": True, **options}, progress)
    vertices, faces = result["mesh"]
    return Mesh(vertices, faces, _report(result))


def inspect_mesh(domain: Domain, *, progress: Progress = None, **options: Any) -> Report:
    """Reports the health of a mesh, whether it can be packed, and what a repair would do.

    domain: as for `repair`. options: those of `vdb_pack mesh`.
    """
    return _report(_run("mesh", domain_words(domain), options, progress))


def inspect_image(domain: Domain, *, progress: Progress = None, **options: Any) -> Report:
    """Reports what an image has in it: size, spacing, axes, labels with volumes, contacts of labels.

    domain: a file, a folder, or an `image`. options: those of `vdb_pack image`.
    """
    return _report(_run("image", domain_words(domain), options, progress))
