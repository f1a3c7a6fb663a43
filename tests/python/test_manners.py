"""Errors, warnings, progress, interrupts and threads."""

import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy
import pytest
from conftest import cube

import vdbpack

VERTICES, FACES = cube(10)


@pytest.mark.parametrize(
    "domain, options, error, word",
    [
        (vdbpack.box(5, 5, 5), {"radius": "uniform:2"}, vdbpack.ParameterError, "uniform"),
        (vdbpack.box(5, 5, 5), {"radios": 1}, vdbpack.ParameterError, "radios is not an option of pack; did you mean radius?"),
        (vdbpack.box(5, 5, 5), {"target-count": 9}, vdbpack.ParameterError, "did you mean target_count?"),
        (vdbpack.box(5, 5, 5), {"density_classes": 3}, vdbpack.ParameterError, "density_classes requires calibrate"),
        (vdbpack.box(5, 5, 5), {"block_side": "a"}, vdbpack.ParameterError, "block_side: 'a' is not a number"),
        (vdbpack.box(5, 5, 5), {"keep_conected": False}, vdbpack.ParameterError, "keep_connected"),
        (vdbpack.box(5, 5, 5), {"radius": 1, "effort": "most"}, vdbpack.ParameterError, "effort"),
        (vdbpack.box(5, 5, 5), {"radius": 1, "target_bvtv": 0.5}, vdbpack.ParameterError, "target_bvtv"),
        (vdbpack.box(5, 5, 5), {"radius": object()}, vdbpack.ParameterError, "radius"),
        (vdbpack.box(5, 5, 5), {"radius": 1, "dry_run": True}, vdbpack.ParameterError, "dry_run"),
        (vdbpack.box(5, 5, 5), {"radius": 1, "seed": "1..3"}, vdbpack.ParameterError, "seed"),
        ("absent.stl", {}, vdbpack.FileError, "absent.stl"),
        (7, {}, vdbpack.ParameterError, "int"),
        ((VERTICES[:, :2], FACES), {}, vdbpack.ParameterError, "vertices"),
        ((VERTICES.ravel(), FACES), {}, vdbpack.ParameterError, "vertices"),
        ((VERTICES, FACES[:, :2]), {}, vdbpack.ParameterError, "faces"),
        ((VERTICES, [["a", "b", "c"]]), {}, vdbpack.ParameterError, "faces"),
        ((numpy.ma.masked_less(VERTICES, 1), FACES), {}, vdbpack.ParameterError, "masked"),
        ((VERTICES * 1j, FACES), {}, vdbpack.ParameterError, "complex"),
        (vdbpack.box(5, 5, 5), {"help": True}, vdbpack.ParameterError, "help"),
        ((VERTICES, FACES + 0.5), {}, vdbpack.ParameterError, "whole"),
        ((VERTICES, FACES + 1), {}, vdbpack.InputError, "names vertex 8"),
        ((VERTICES, FACES - 1), {}, vdbpack.InputError, "names vertex -1"),
        ((VERTICES, FACES[:0]), {}, vdbpack.InputError, "none"),
        ((numpy.where(VERTICES > 5, numpy.nan, VERTICES), FACES), {}, vdbpack.InputError, "finite"),
        (vdbpack.box(1000, 1000, 1000), {"radius": 0.5, "memory_limit": "200M"}, vdbpack.ResourceError, ""),
    ],
)
def test_errors(domain, options, error, word):
    with pytest.raises(error) as told:
        vdbpack.pack(domain, **options)
    assert word in str(told.value)
    assert "--" not in str(told.value)
    assert isinstance(told.value, vdbpack.Error)


def test_errors_quote_files_as_they_are_named():
    with pytest.raises(vdbpack.FileError, match="left--shell-radius.stl"):
        vdbpack.pack("left--shell-radius.stl", radius=1)


def test_a_recipe_that_cannot_repeat_the_run_is_not_left(tmp_path):
    for radius, leaves in (1.0, True), (vdbpack.table([1, 1.2], [0.5, 0.5]), False):
        vdbpack.pack(vdbpack.ball(5), radius=radius, output=tmp_path / f"{leaves}.csv")
        assert (tmp_path / f"{leaves}.recipe.toml").is_file() == leaves


def test_errors_are_also_pythons_own():
    assert issubclass(vdbpack.ParameterError, ValueError)
    assert issubclass(vdbpack.InputError, ValueError)
    assert issubclass(vdbpack.FileError, OSError)
    assert issubclass(vdbpack.ResourceError, MemoryError)


@pytest.mark.parametrize(
    "positions, radii, columns",
    [
        (numpy.zeros((3, 4)), numpy.ones(3), {}),
        (numpy.zeros(3), numpy.ones(3), {}),
        (numpy.zeros((3, 3)), numpy.ones(2), {}),
        (numpy.zeros((3, 3)), numpy.ones((3, 1)), {}),
        (numpy.full((1, 3), numpy.nan), numpy.ones(1), {}),
        (numpy.ma.masked_equal(numpy.eye(3), 0), numpy.ones(3), {}),
        (numpy.zeros((1, 3)), numpy.ones(1), {"x": [9]}),
        (numpy.zeros((1, 3)), [-1.0], {}),
        (numpy.zeros((1, 3)), [numpy.inf], {}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"id": [1]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"id": [1, 2.5]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"region": [0, 2**40]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"material": ["a"]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"weight": [[1, 2]]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"weight": numpy.ma.masked_equal([1.0, 2], 2)}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"weight": [1j, 2]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"weight": ["a", 1]}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"weight": numpy.array(["2026-01-01"] * 2, "datetime64[D]")}),
        (numpy.zeros((2, 3)), numpy.ones(2), {"id": numpy.array([0, 2**63], "u8")}),
        ([["a", "b", "c"]], numpy.ones(1), {}),
        ([[1, 2, 3], [1, 2]], numpy.ones(2), {}),
        ({"a": 1}, numpy.ones(2), {}),
    ],
)
def test_arrays_that_are_no_pack(positions, radii, columns):
    with pytest.raises(vdbpack.Error):
        vdbpack.Pack(positions, radii, **columns)


@pytest.mark.parametrize(
    "make, word",
    [
        (lambda: vdbpack.image(numpy.ones((3, 3)), numpy.eye(4)), "(3, 3)"),
        (lambda: vdbpack.image(numpy.ones((3, 3, 3)), numpy.eye(3)), "(3, 3)"),
        (lambda: vdbpack.image(numpy.ones((3, 3, 3)), numpy.eye(4) * numpy.nan), "finite"),
        (lambda: vdbpack.image(numpy.ones((3, 3, 3)), numpy.eye(4) + 1), "last row"),
        (lambda: vdbpack.level_set(numpy.ones((3, 3)), 1), "(3, 3)"),
        (lambda: vdbpack.level_set(numpy.ones((3, 3, 3)), 0), "spacing"),
        (lambda: vdbpack.level_set(numpy.ones((3, 3, 3)), (1, 1, 1)), "spacing"),
        (lambda: vdbpack.Pack(numpy.zeros((3, 5)), numpy.ones(5)), "(3, 5)"),
        (lambda: vdbpack.write_points("p.csv", numpy.zeros((1, 3)), [1]), ".vdb"),
        (lambda: vdbpack.write(vdbpack.Pack([[0, 0, 0]], [1]), "p.vdb", unit=1), "unit"),
        (lambda: vdbpack.morphometry(vdbpack.Pack([[0, 0, 0]], [1])), "measure"),
        (lambda: vdbpack.pack(vdbpack.box(5, 5, 5), radius=1, existing=3), "existing"),
    ],
)
def test_what_was_given_is_told(make, word):
    with pytest.raises(vdbpack.ParameterError) as told:
        make()
    assert word in str(told.value)


def test_texts_of_any_bytes(tmp_path):
    (tmp_path / "bad.csv").write_bytes("x,y,z,radius,größe\n1,2,3,bäd,5\n".encode("latin1"))
    with pytest.raises(vdbpack.InputError, match="radius"):
        vdbpack.read(tmp_path / "bad.csv")
    (tmp_path / "good.csv").write_bytes("x,y,z,radius,art\n1,2,3,1,größe\n".encode("latin1"))
    assert len(vdbpack.read(tmp_path / "good.csv").columns["art"]) == 1


def test_damaged_file(tmp_path):
    (tmp_path / "p.csv").write_text("x,y,z,radius\n1,2,3,x\n")
    with pytest.raises(vdbpack.InputError, match="p.csv"):
        vdbpack.read(tmp_path / "p.csv")
    with pytest.raises(vdbpack.ParameterError):
        vdbpack.read(tmp_path / "p.unknown")


def test_warnings_are_pythons():
    with pytest.warns(vdbpack.VdbpackWarning, match="unit has no effect") as told:
        vdbpack.pack(vdbpack.box(8, 8, 8), radius=1, unit="m")
    assert told[0].filename == __file__  # the caller's line


def test_a_warning_comes_once_in_a_loop():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("default")
        for seed in range(3):
            vdbpack.pack(vdbpack.box(8, 8, 8), radius=1, unit="m", seed=seed)
    assert len(told) == 1


def test_a_module_without_its_compiled_part_says_what_to_build(tmp_path):
    folder = tmp_path / "vdbpack"
    folder.mkdir()
    for source in pathlib.Path(vdbpack.__file__).parent.glob("*.py"):
        (folder / source.name).write_text(source.read_text())
    done = subprocess.run([sys.executable, "-c", "import vdbpack"], cwd=tmp_path, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True)
    assert "--target vdbpack_python" in done.stderr and "circular" not in done.stderr.splitlines()[-1]


def test_progress():
    told = []
    vdbpack.pack(vdbpack.box(90, 90, 90), radius=vdbpack.uniform(0.5, 1), progress=lambda *p: told.append(p))
    assert any(stage == "pack" for stage, _, _ in told)
    assert all(0 <= fraction <= 1 for _, fraction, _ in told)


def test_progress_that_fails_ends_the_run():
    def fails(*_):
        raise RuntimeError("enough")

    start = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        vdbpack.pack(vdbpack.box(400, 400, 400), radius=vdbpack.uniform(0.5, 1), progress=fails)
    assert time.monotonic() - start < 20


def test_interrupt_within_half_a_second():
    x = numpy.linspace(-5, 5, 220)
    wide = numpy.abs(numpy.stack(numpy.meshgrid(x, x, x, indexing="ij"))).max(axis=0)
    waves = numpy.sin(3 * x)[:, None, None] * numpy.sin(3 * x)[:, None] + numpy.sin(3 * x)
    sponge = vdbpack.level_set(numpy.maximum(0.3 * waves, wide - 4.8), x[1] - x[0], (-5, -5, -5))
    for work in (
        lambda: vdbpack.pack(vdbpack.box(300, 300, 300), radius=vdbpack.uniform(0.5, 1)),
        lambda: vdbpack.pack(vdbpack.box(60, 60, 60), radius=vdbpack.uniform(0.5, 1), densify="max"),
        # Has stages that cannot be stopped: they end in the background.
        lambda: vdbpack.morphometry(sponge),
    ):
        sent = []

        def send():
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(1.0, send)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            work()
        assert time.monotonic() - sent[0] < 3  # half a second, but machines are loaded
    assert len(vdbpack.pack(vdbpack.box(8, 8, 8), radius=1)) > 0


def test_two_packs_at_a_time():
    alone = [vdbpack.pack(vdbpack.box(30, 30, 30), radius=0.8, seed=seed).hash for seed in (1, 2)]
    together = [None, None]

    def work(k):
        together[k] = vdbpack.pack(vdbpack.box(30, 30, 30), radius=0.8, seed=k + 1).hash

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone


def test_other_threads_run_meanwhile():
    counted = []
    ended = threading.Event()

    def count():
        while not ended.is_set():
            counted.append(1)
            time.sleep(0.01)

    thread = threading.Thread(target=count)
    thread.start()
    vdbpack.pack(vdbpack.box(70, 70, 70), radius=vdbpack.uniform(0.5, 1), threads=1)
    ended.set()
    thread.join()
    assert len(counted) > 10


def test_quiet_by_default(capfd):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        vdbpack.pack(vdbpack.box(20, 20, 20), radius=1)
    said = capfd.readouterr()
    assert said.out == "" and said.err == ""


def test_a_pack_made_of_arrays_keeps_its_parts(tmp_path):
    pack = vdbpack.Pack([[0, 0, 0], [3, 0, 0]], [1, 1], part=[0, 1], part_names=["bone", "screw"])
    pack.write(tmp_path / "p.vtp")
    for same in (pack, vdbpack.read(tmp_path / "p.vtp"), pickle.loads(pickle.dumps(pack))):
        assert same.part_names == ["bone", "screw"]
    with pytest.raises(vdbpack.ParameterError, match="part_names"):
        vdbpack.Pack([[0, 0, 0]], [1], part_names=["bone"])


@pytest.mark.parametrize("name", ["bond:b.csv", "contact:c.csv", "lamps-bonds:b.data", "bonds:b.csv", "s.stl"])
def test_what_is_no_pack_is_not_written(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(vdbpack.ParameterError, match=name.split(".")[0]):
        vdbpack.Pack([[0, 0, 0]], [1]).write(name)
    assert not list(tmp_path.iterdir())
