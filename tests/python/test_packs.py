"""Packs from shapes, arrays and files, against the command line."""

import json
import pickle
import subprocess
import sys
import types

import numpy
import pytest
from conftest import cube, write_off

import vdbpack

BOX = ["box:16,14,12", "--radius", "uniform:0.6,1.2", "--seed", "7"]
#: words after `vdb_pack pack`, and the same as arguments
SAME = [
    (BOX, (vdbpack.box(16, 14, 12), {"radius": vdbpack.uniform(0.6, 1.2), "seed": 7})),
    (["ball:8", "--radius", "constant:0.9"], (vdbpack.ball(8), {"radius": 0.9})),
    (["cylinder:6,20", "--target-count", "3000"], (vdbpack.cylinder(6, 20), {"target_count": 3000})),
    (["rect:60,40", "--radius", "uniform:0.5,1"], (vdbpack.rect(60, 40), {"radius": "uniform:0.5,1"})),
    (["disc:30", "--radius", "lognormal:1,0.3,0.5,2"],
     (vdbpack.disc(30), {"radius": vdbpack.lognormal(1, 0.3, 0.5, 2)})),
    ([*BOX, "--densify", "max"],
     (vdbpack.box(16, 14, 12), {"radius": "uniform:0.6,1.2", "seed": 7, "densify": "max"})),
    ([*BOX, "--shell", "2", "--voids", "boolean", "--target-bvtv", "0.4", "--void-axis", "0,0,1"],
     (vdbpack.box(16, 14, 12),
      {"radius": "uniform:0.6,1.2", "seed": 7, "shell": 2, "voids": "boolean", "target_bvtv": 0.4,
       "void_axis": (0, 0, 1)})),
    ([*BOX, "--clip", "plane:1,0,0,4", "--clip", "plane:0,1,0,3", "--gap", "0.05"],
     (vdbpack.box(16, 14, 12),
      {"radius": "uniform:0.6,1.2", "seed": 7, "clip": ["plane:1,0,0,4", "plane:0,1,0,3"], "gap": 0.05})),
    ([*BOX, "--effort", "fast", "--order", "wall"],
     (vdbpack.box(16, 14, 12),
      {"radius": "uniform:0.6,1.2", "seed": 7, "effort": "fast", "order": "wall"})),
    ([*BOX, "--max-count", "500", "--threads", "1"],
     (vdbpack.box(16, 14, 12), {"radius": "uniform:0.6,1.2", "seed": 7, "max_count": 500, "threads": 1})),
]


def hash_by(program, words, folder):
    report = folder / "r.json"
    subprocess.run([program, "pack", *words, "--report", report, "--quiet", "-o", folder / "p.npz"], check=True)
    return json.loads(report.read_text())["hash"]


@pytest.mark.parametrize("words, call", SAME)
def test_same_hash_as_the_command_line(program, tmp_path, words, call):
    domain, options = call
    pack = vdbpack.pack(domain, **options)
    assert pack.hash == pack.report["hash"] == hash_by(program, words, tmp_path)


def test_mesh_from_arrays(program, tmp_path):
    vertices, faces = cube(12)
    pack = vdbpack.pack((vertices, faces), radius=vdbpack.uniform(0.5, 1))
    assert len(pack) > 300
    assert vdbpack.verify(pack, (vertices, faces)).passed
    low = pack.positions - pack.radii[:, None]
    high = pack.positions + pack.radii[:, None]
    assert low.min() >= -1e-9 and high.max() <= 12 + 1e-9
    # The same mesh as a file gives the same pack.
    write_off(tmp_path / "cube.off", (vertices, faces))
    assert vdbpack.pack(tmp_path / "cube.off", radius="uniform:0.5,1").hash == pack.hash
    # As do other layouts and types of the arrays, and a unit.
    other = (numpy.asfortranarray(vertices / 1000), faces.astype(numpy.uint8))
    assert vdbpack.pack(other, radius="uniform:0.5,1", unit="m").hash == pack.hash


def test_meshes_of_other_packages():
    class Trimesh:
        vertices, faces = cube(10)

    class Meshio:
        points, cells_dict = cube(10)[0], {"triangle": cube(10)[1]}

    first = vdbpack.pack(Trimesh, radius=0.8)
    assert first.hash == vdbpack.pack(Meshio, radius=0.8).hash == vdbpack.pack(cube(10), radius=0.8).hash


def test_views_share_memory_and_are_read_only():
    pack = vdbpack.pack(vdbpack.box(10, 10, 10), radius=vdbpack.uniform(0.5, 1))
    n = len(pack)
    assert pack.positions.shape == (n, 3) and pack.positions.dtype == numpy.float64
    assert pack.radii.shape == (n,) and pack.radii.dtype == numpy.float64
    for name in ("region", "order", "depth", "contacts"):
        assert getattr(pack, name).shape == (n,)
    assert pack.id.tolist() == list(range(n))
    assert numpy.shares_memory(pack.positions, pack.positions)
    assert numpy.shares_memory(pack.depth, pack.depth)
    with pytest.raises(ValueError):
        pack.positions[0, 0] = 1
    with pytest.raises(ValueError):
        pack.radii[:] = 1


def test_pairs_in_contact():
    pack = vdbpack.pack(vdbpack.box(12, 12, 12), radius=vdbpack.uniform(0.8, 1.6))
    indices, gaps = pack.pairs(0.05)
    i, j = numpy.triu_indices(len(pack), 1)
    apart = numpy.linalg.norm(pack.positions[i] - pack.positions[j], axis=1) - pack.radii[i] - pack.radii[j]
    near = apart <= 0.05 * numpy.minimum(pack.radii[i], pack.radii[j])
    assert near.sum() > len(pack)
    assert (indices == numpy.column_stack([i, j])[near]).all()
    assert numpy.allclose(gaps, apart[near], atol=1e-12)
    assert 2 * len(pack.pairs()[0]) <= pack.contacts.sum()
    with pytest.raises(vdbpack.ParameterError):
        pack.pairs(-1)


def test_views_outlive_the_pack():
    pack = vdbpack.pack(vdbpack.box(10, 10, 10), radius=0.8)
    positions, total = pack.positions, pack.positions.sum()
    data = pack._data
    views = [pack.radii for _ in range(1000)]
    held = sys.getrefcount(data)
    assert held > 1000
    del views, pack
    assert sys.getrefcount(data) <= held - 1000
    del data
    assert positions.sum() == total


def test_pack_of_arrays_and_back(tmp_path):
    positions = numpy.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    pack = vdbpack.Pack(positions, [1, 1.0, 0.5], id=[5, 6, 9], material=["a", "b", "c"], weight=[1, 2, 3])
    assert pack.id.tolist() == [5, 6, 9]
    assert pack.columns["material"] == ["a", "b", "c"]
    assert pack.columns["weight"].tolist() == [1, 2, 3]
    with pytest.raises(TypeError):
        pack.columns["new"] = [1, 2, 3]
    assert vdbpack.Pack(positions, [1, 1, 1], region=None).region is None
    for name in ("p.vdb", "p.vtp", "p.csv", "p.npz"):
        vdbpack.write(pack, tmp_path / name)
        back = vdbpack.read(tmp_path / name)
        assert back.hash == pack.hash
        assert back.id.tolist() == [5, 6, 9]
    pack.write(tmp_path / "m.vtp", unit="m")
    assert numpy.allclose(vdbpack.read(tmp_path / "m.vtp").positions, positions)


def test_points_of_a_vdb(tmp_path):
    pack = vdbpack.pack(vdbpack.ball(6), radius=vdbpack.uniform(0.4, 0.8))
    vdbpack.write_points(tmp_path / "p.vdb", pack)
    back = vdbpack.read_points(tmp_path / "p.vdb")
    assert back.hash == pack.hash
    assert (back.positions == pack.positions).all() and (back.radii == pack.radii).all()
    vdbpack.write_points(tmp_path / "a.vdb", [[0, 0, 0], [2, 0, 1]], [1, 0.5], id=[7, 8], weight=[0.25, 3])
    back = vdbpack.read_points(tmp_path / "a.vdb")
    assert back.positions.tolist() == [[0, 0, 0], [2, 0, 1]] and back.radii.tolist() == [1, 0.5]
    assert back.id.tolist() == [7, 8] and back.columns["weight"].tolist() == [0.25, 3]
    with pytest.raises(vdbpack.ParameterError, match="radii"):
        vdbpack.write_points(tmp_path / "b.vdb", [[0, 0, 0]])
    with pytest.raises(vdbpack.ParameterError, match="radii"):
        vdbpack.write_points(tmp_path / "b.vdb", pack, pack.radii)


def test_circles():
    pack = vdbpack.pack(vdbpack.rect(30, 20), radius=vdbpack.uniform(0.5, 1))
    assert pack.positions.shape == (len(pack), 2)
    assert pack.slice_height == 0
    sliced = vdbpack.pack(vdbpack.ball(8), slice="z=3", radius=0.5)
    assert pickle.loads(pickle.dumps(sliced)).slice_height == sliced.slice_height == 3
    assert "circles" in repr(pack)
    assert vdbpack.verify(pack, vdbpack.rect(30, 20)).passed


def test_pickle_and_repr():
    pack = vdbpack.pack(vdbpack.box(8, 8, 8), radius=0.7)
    back = pickle.loads(pickle.dumps(pack))
    assert back.hash == pack.hash and back.report == pack.report
    assert (back.depth == pack.depth).all()
    assert f"{len(pack):,} spheres" in repr(pack) and "solid fraction" in repr(pack)
    assert "<pre>" in pack._repr_html_()
    assert "spheres" in str(pack.report)


def test_picture_for_a_notebook():
    pack = vdbpack.pack(vdbpack.box(6, 6, 6), radius=1, preview=True)
    assert pack.picture is not None and pack.picture[:4] == b"\x89PNG"
    assert max(int.from_bytes(pack.picture[at : at + 4], "big") for at in (16, 20)) == 480
    assert "<img" in pack._repr_html_() and "<img" in pickle.loads(pickle.dumps(pack))._repr_html_()


def test_existing_spheres_are_kept():
    first = vdbpack.pack(vdbpack.box(10, 10, 10), radius=1, max_count=20)
    both = vdbpack.pack(vdbpack.box(10, 10, 10), radius=0.5, existing=first)
    assert len(both) > len(first)
    assert (both.positions[: len(first)] == first.positions).all()
    assert both.columns["existing"].sum() == len(first)


def test_densify_carve_measure_convert(tmp_path):
    domain = vdbpack.box(14, 14, 14)
    pack = vdbpack.pack(domain, radius=vdbpack.uniform(0.5, 1))
    dense = vdbpack.densify(pack, domain, densify="max")
    assert dense.report["solidFraction"]["total"] > pack.report["solidFraction"]["total"] + 0.01
    carved = vdbpack.carve(dense, domain, voids="boolean", void_radius=1.5, target_bvtv=0.5, shell=1)
    assert 0 < len(carved) < len(dense)
    assert carved.report["voids"]["bvtv"] == pytest.approx(0.5, abs=0.01)
    measured = vdbpack.measure(dense, domain)
    assert measured["solidFraction"]["total"] == pytest.approx(dense.report["solidFraction"]["total"], abs=1e-3)
    told = vdbpack.convert(dense, output=(str(tmp_path / "p.vtp"), tmp_path / "p.csv"))
    assert told["count"] == len(dense) and (tmp_path / "p.vtp").is_file()


def test_voids_and_morphometry(tmp_path):
    domain = vdbpack.box(12, 12, 12)
    made = vdbpack.voids(domain, voids="boolean", void_radius="uniform:0.8,1.2", target_bvtv=0.3,
                         output=str(tmp_path / "s.vdb"))
    assert made.report["voids"]["bvtv"] == pytest.approx(0.3, abs=0.01)
    assert made.centers.shape == made.axes.shape == (len(made), 3)
    assert made.half_axes.shape == (len(made), 2)
    assert (made.half_axes[:, 1] >= 0.8).all() and (made.half_axes[:, 1] <= 1.2).all()
    assert numpy.allclose(numpy.linalg.norm(made.axes, axis=1), 1)
    solid = made.solid
    assert (solid.values < 0).mean() * solid.values.size * solid.spacing**3 == pytest.approx(
        0.3 * 12**3, rel=0.02)
    # As an array it is what the file has.
    ours = vdbpack.morphometry(solid, domain)
    theirs = vdbpack.morphometry(tmp_path / "s.vdb", domain, grid="solid")
    for name in ("BV/TV", "Tb.N", "Conn.D"):
        assert ours["morphometry"][name] == pytest.approx(theirs["morphometry"][name], rel=1e-6)


def test_level_set_of_an_array():
    x, y, z = numpy.meshgrid(*[numpy.arange(-12, 13) * 0.5] * 3, indexing="ij")
    values = numpy.sqrt(x**2 + y**2 + z**2) - 5
    ball = vdbpack.level_set(values, 0.5, (4, 4, 4))
    pack = vdbpack.pack(ball, radius=vdbpack.uniform(0.5, 1))
    assert pack.report["domain"]["volume"] == pytest.approx(4 / 3 * numpy.pi * 125, rel=0.02)
    assert (numpy.linalg.norm(pack.positions - 10, axis=1) + pack.radii).max() < 5.05
    assert vdbpack.verify(pack, ball).passed
    with pytest.raises(vdbpack.InputError, match="border"):
        vdbpack.pack(vdbpack.level_set(values - 2, 0.5), radius=1)
    with pytest.raises(vdbpack.InputError, match="inside"):
        vdbpack.pack(vdbpack.level_set(values + 9, 0.5), radius=1)
    with pytest.raises(vdbpack.InputError, match="finite"):
        vdbpack.pack(vdbpack.level_set(values * numpy.nan, 0.5), radius=1)
    for array, spacing in ((values[0], 0.5), (values, 0), (values[:2], 0.5)):
        with pytest.raises(vdbpack.ParameterError):
            vdbpack.pack(vdbpack.level_set(array, spacing), radius=1)


def test_repair_of_arrays():
    vertices, faces = cube(10)
    assert vdbpack.inspect_mesh((vertices, faces))["boundaryEdges"] == 0
    assert vdbpack.inspect_mesh((vertices, faces[1:]))["boundaryEdges"] == 3
    repaired = vdbpack.repair((vertices, faces[1:]))
    assert repaired.report["boundaryEdges"] == 0
    a, b, c = (repaired.vertices[repaired.faces[:, k]] for k in range(3))
    assert numpy.einsum("ij,ij->", a, numpy.cross(b, c)) / 6 == pytest.approx(1000, rel=0.05)
    assert vdbpack.verify(vdbpack.pack(repaired, radius=1), (vertices, faces)).passed


def test_prediction():
    domain = vdbpack.box(20, 20, 20)
    expected = vdbpack.predict(domain, radius=vdbpack.uniform(0.5, 1))
    assert expected["dryRun"]
    assert expected["spheres"]["count"] == pytest.approx(len(vdbpack.pack(domain, radius="uniform:0.5,1")), rel=0.1)


def test_morphometry_of_arrays():
    x = numpy.arange(-20, 20) + 0.5
    rods = numpy.broadcast_to(numpy.hypot(x[:, None] % 20 - 10, x % 20 - 10) < 4, (40, 40, 40)).astype(numpy.uint8)
    share = rods.mean()
    try:
        told = vdbpack.morphometry(vdbpack.image(rods, numpy.diag([0.02, 0.02, 0.02, 1])), label=1)["morphometry"]
    except vdbpack.ParameterError:
        pytest.skip("this build has no images")
    assert told["BV/TV"] == pytest.approx(share, rel=0.02)
    assert told["TV"] == pytest.approx(0.8**3)
    assert told["Tb.Th"]["mean"] == pytest.approx(0.16, rel=0.1)
    turned = numpy.array([[0.016, 0.012, 0, 5], [-0.012, 0.016, 0, 6], [0, 0, 0.02, 7], [0, 0, 0, 1]])
    askew = vdbpack.morphometry(vdbpack.image(rods, turned), label=1)["morphometry"]
    assert askew["BV/TV"] == pytest.approx(told["BV/TV"]) and askew["TV"] == pytest.approx(told["TV"])
    box = vdbpack.morphometry(cube(2), vdbpack.box(0, 0, 0, 4, 2, 2))["morphometry"]
    assert box["BV/TV"] == pytest.approx(0.5, abs=0.02)


def test_labels_of_an_image():
    size = numpy.array([24, 20, 18])
    x, y, z = numpy.meshgrid(*(numpy.arange(n) - n / 2 for n in size), indexing="ij")
    labels = ((x**2 + y**2 + z**2) < 64) * (1 + (x > 0))
    affine = numpy.diag([1.0, 1.0, 1.0, 1.0])
    affine[:3, 3] = [100, -50, 20]
    image = vdbpack.image(labels, affine)
    try:
        told = vdbpack.inspect_image(image)
    except vdbpack.ParameterError:
        pytest.skip("this build has no images")
    assert [label["value"] for label in told["labels"]] == [1, 2]
    pack = vdbpack.pack(image, label="all", radius=vdbpack.uniform(0.6, 1.2), space="ras")
    assert set(pack.columns["part"]) == {0.0, 1.0}
    assert pack.part_names == ["1", "2"] and vdbpack.pack(vdbpack.ball(5), radius=1.0).part_names == []
    assert vdbpack.verify(pack, image, label="all", space="ras").passed
    nibabel = types.SimpleNamespace(dataobj=labels, affine=affine)
    assert vdbpack.pack(nibabel, label="all", radius=vdbpack.uniform(0.6, 1.2), space="ras").hash == pack.hash
    # In the unit that its header states.
    header = types.SimpleNamespace(get_xyzt_units=lambda: ("meter", "sec"))
    scaled = numpy.diag([1e-3, 1e-3, 1e-3, 1]) @ affine
    nibabel = types.SimpleNamespace(dataobj=labels[..., None], affine=scaled, header=header)
    meters = vdbpack.pack(nibabel, label="all", radius=vdbpack.uniform(0.6, 1.2), space="ras")
    assert numpy.abs(meters.positions.mean(axis=0) - pack.positions.mean(axis=0)).max() < 0.1
    assert set(vdbpack.pack(image, label=[1.0, 2], radius=1.0).columns["part"]) == {0.0, 1.0}
    # In the world of the affine.
    middle = affine @ [*(size / 2), 1]
    assert numpy.abs(pack.positions.mean(axis=0) - middle[:3]).max() < 1


def test_grids_of_pyopenvdb():
    openvdb = pytest.importorskip("openvdb" if vdbpack._domains.util.find_spec("openvdb") else "pyopenvdb")
    sphere = openvdb.createLevelSetSphere(radius=6, center=(20, 0, 0), voxelSize=0.5)
    pack = vdbpack.pack(sphere, radius=vdbpack.uniform(0.5, 1))
    assert pack.report["domain"]["volume"] == pytest.approx(4 / 3 * numpy.pi * 216, rel=0.02)
    assert abs(pack.positions.mean(axis=0) - [20, 0, 0]).max() < 0.5
    made = vdbpack.voids(sphere, voids="boolean", void_radius=1.5, target_bvtv=0.5)
    grid = made.solid.to_pyopenvdb()
    assert grid.gridClass == openvdb.GridClass.LEVEL_SET
    again = vdbpack.morphometry(vdbpack.level_set(*array_of(grid)))["morphometry"]
    assert again["BV/TV"] == pytest.approx(vdbpack.morphometry(made.solid)["morphometry"]["BV/TV"], rel=0.02)


def array_of(grid):
    low, high = grid.evalActiveVoxelBoundingBox()
    values = numpy.empty([h - l + 3 for l, h in zip(low, high)], "f4")
    low = tuple(c - 1 for c in low)
    grid.copyToArray(values, ijk=low)
    return values, grid.transform.voxelSize()[0], grid.transform.indexToWorld(low)


def test_table_of_weights():
    pack = vdbpack.pack(vdbpack.box(60, 60, 60), radius=vdbpack.table([0.5, 1.0], [3, 1]))
    assert set(numpy.round(pack.radii, 6)) == {0.5, 1.0}
    assert (pack.radii < 0.75).mean() == pytest.approx(0.75, abs=0.01)


def test_voids_can_be_pickled():
    made = vdbpack.voids(vdbpack.box(8, 8, 8), voids="boolean", void_radius=1, target_bvtv=0.5)
    back = pickle.loads(pickle.dumps(made))
    assert (back.centers == made.centers).all() and (back.solid.values == made.solid.values).all()


def test_files_named_like_commands_and_options(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_off(tmp_path / "-x.off", cube(8))
    assert len(vdbpack.pack("-x.off", radius=0.8)) > 20
    with pytest.raises(vdbpack.Error, match="mesh"):
        vdbpack.pack("mesh", radius=0.8)  # a file, not a command


def test_numbers_of_numpy_are_options():
    assert len(vdbpack.pack(vdbpack.ball(4), radius=numpy.float32(0.5), seed=numpy.int64(3))) > 0
    assert len(vdbpack.pack(vdbpack.ball(4), radius=numpy.int64(1))) > 0


def test_failed_checks_say_why():
    checked = vdbpack.verify(vdbpack.Pack([[0, 0, 0], [1.5, 0, 0]], [1, 1]), vdbpack.ball(9))
    assert not checked.passed and "overlap" in checked.failures


def test_recipe_repeats_a_run(tmp_path):
    first = vdbpack.pack(vdbpack.ball(6), radius="uniform:0.5,1", seed=3, output=tmp_path / "p.csv")
    again = vdbpack.pack(config=tmp_path / "p.recipe.toml")
    assert again.hash == first.hash
    assert vdbpack.pack(config=tmp_path / "p.recipe.toml", seed=4).hash != first.hash


def test_files_whose_columns_have_no_names(tmp_path):
    file = tmp_path / "d.dat"
    file.write_text("0 0 0 1\n3 0 0 1.5\n")
    assert list(vdbpack.read(file, columns="x,y,z,r").radii) == [1, 1.5]
    file.write_text("x y z\n0 0 0\n")
    assert list(vdbpack.read(file, pack_radius=2).radii) == [2]
    with pytest.raises(vdbpack.FileError, match="No such file"):
        vdbpack.pack(config=tmp_path / "no.toml")


def test_parts_of_a_file(tmp_path):
    write_off(tmp_path / "a.off", cube(8))
    (tmp_path / "p.toml").write_text("[[part]]\nname = 'a'\ndomain = 'a.off'\n")
    assert len(vdbpack.pack(parts=str(tmp_path / "p.toml"), radius=0.8)) > 20


def test_dataframe():
    pandas = pytest.importorskip("pandas")
    pack = vdbpack.pack(vdbpack.ball(5), radius=0.8)
    table = pack.to_dataframe()
    assert isinstance(table, pandas.DataFrame) and len(table) == len(pack)
    assert list(table.columns[:5]) == ["id", "x", "y", "z", "radius"]


def test_vtk():
    pytest.importorskip("vtkmodules")
    pack = vdbpack.pack(vdbpack.ball(5), radius=0.8)
    data = pack.to_vtk()
    assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == len(pack)
    assert data.GetPointData().GetArray("radius").GetValue(0) == pack.radii[0]


def test_every_public_name_has_a_docstring():
    for name in vdbpack.__all__:
        if name.startswith("__"):
            continue
        thing = getattr(vdbpack, name)
        assert (thing.__doc__ or "").strip(), name
        for member in vars(thing) if isinstance(thing, type) else ():
            value = vars(thing)[member]
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert (value.__doc__ or "").strip(), f"{name}.{member}"


def test_stiffness_of_bonds_is_a_matrix():
    pack = vdbpack.pack(vdbpack.box(10, 10, 10), radius="uniform:0.6,1")
    found = vdbpack.stiffness(pack, vdbpack.box(10, 10, 10), contact_tol=0.01, bond_modulus=500)
    matrix = numpy.array(found["stiffness"])
    assert matrix.shape == (6, 6)
    assert numpy.allclose(matrix, matrix.T, atol=1e-3 * matrix.max())
    assert (numpy.linalg.eigvalsh(0.5 * (matrix + matrix.T)) > 0).all()
    assert found["bonds"]["count"] > len(pack)
