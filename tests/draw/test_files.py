"""Files of other programs, each opened by a reader that others wrote."""

import json

import numpy as np
import pytest
from examples.drawn import FRAMES, write_run

from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.selection import Selection
from warp_rods.errors import SceneError, WarpRodsError
from warp_rods.simulation.trajectory import STORE, SWIMMER_VARIABLES, GroupSpec, TrajectoryWriter

TIMES = 0.1 * np.arange(FRAMES)
FAILED = 4
FILES = ("html", "vtkhdf", "gsd", "simularium", "wcon", "csv")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run on a membrane in which rod 1 of "sensors" is lost at frame 4; one unit is 2.5 µm and 1 ms."""
    folder = tmp_path_factory.mktemp("run")
    write_run(folder, '[units]\nlength = "2.5 um"\ntime = "1 ms"', fail_at=FAILED)
    return folder


@pytest.fixture(scope="module")
def shown(run):
    """All of it."""
    return content(run)


def near(found, expected, tolerance: float = 2e-6) -> None:
    """Single precision, unless a tolerance is given; NaN where NaN is expected."""
    np.testing.assert_allclose(found, np.broadcast_to(expected, np.shape(found)), rtol=tolerance, atol=tolerance)


def saved(shown, index: int) -> np.ndarray:
    """Positions of an ensemble as saved, [frame, rod, node, 3]; NaN where a rod is lost."""
    data = shown.rods[index].data
    return data["position"].where(data["status"] == 0).values


def write_periodic(folder) -> None:
    """Two cells that swim along x beside a periodic box."""
    scene = """
    swimmers = [{ name = "cell", count = 2, nodes = 17, bend = 5e-3, twist = 1e-3 }]
    box = { kind = "periodic", size = [2.0, 2.5, 3.0] }
    time = { end = 1.0 }
    """
    spec = GroupSpec(2, 17, SWIMMER_VARIABLES)
    writer = TrajectoryWriter.create(folder / STORE, {"cell": spec}, {"title": "", "scene": scene, "scene_hash": "a"})
    for number in range(FRAMES):
        saved = {name: np.zeros(spec.shape(variable)) for name, variable in spec.variables.items()}
        saved["position"][..., 0] = np.linspace(0.5, 1.5, 17) + 0.4 * number
        saved["position"][1] += [0.0, -1.2, 1.0]
        writer.append(0.1 * number, {"cell": saved})
    writer.close()


def vtk_steps(path):
    """PolyData of each step, as VTK reads it when the time changes, and the times."""
    pytest.importorskip("vtkmodules", reason="vtk is not installed: pip install 'warp-rods[test]'")
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    times = [information.Get(Pipeline.TIME_STEPS(), i) for i in range(information.Length(Pipeline.TIME_STEPS()))]
    for time in times:
        reader.UpdateTimeStep(time)
        yield time, reader.GetOutputDataObject(0)


def test_vtk_reads_rods_with_their_variables_at_every_time(run, shown):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    folder = EXPORTERS["vtkhdf"].write(shown, run / "vtkhdf")
    assert sorted(path.name for path in folder.iterdir()) == [
        "membrane.vtkhdf",
        "rods_cell.vtkhdf",
        "rods_sensors.vtkhdf",
    ]
    rods = next(rods for rods in shown.rods if rods.name == "sensors")
    times = []
    for frame, (time, data) in enumerate(vtk_steps(folder / "rods_sensors.vtkhdf")):
        times.append(time)
        near(vtk_to_numpy(data.GetPoints().GetData()), rods.positions(frame).reshape(-1, 3))
        assert data.GetNumberOfLines() == 4 and data.GetNumberOfCells() == 4
        ids = data.GetCell(2).GetPointIds()
        assert [ids.GetId(i) for i in range(ids.GetNumberOfIds())] == list(range(18, 27))
        for name, where in (("energy_density", data.GetPointData()), ("status", data.GetCellData())):
            expected = rods.variable(name, frame).ravel()
            near(vtk_to_numpy(where.GetArray(name)), expected)
        assert vtk_to_numpy(data.GetPointData().GetArray("strain")).shape == (36, 3)
    near(times, TIMES)


def test_vtk_reads_a_membrane_that_is_stored_once(run, shown):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    folder = EXPORTERS["vtkhdf"].write(shown, run / "vtkhdf")
    mesh = shown.membrane.mesh(0)
    for _, data in vtk_steps(folder / "membrane.vtkhdf"):
        assert data.GetNumberOfPolys() == len(mesh.triangles)
        near(vtk_to_numpy(data.GetPoints().GetData()), mesh.points)
        near(vtk_to_numpy(data.GetPointData().GetArray("gaussian_curvature")), 1.0)
    import h5py

    with h5py.File(folder / "membrane.vtkhdf") as file:
        assert len(file["VTKHDF/Points"]) == len(mesh.points)


def test_beads_and_bonds_of_gsd(run, shown):
    hoomd = pytest.importorskip("gsd.hoomd", reason="gsd is not installed: pip install 'warp-rods[files]'")
    path = EXPORTERS["gsd"].write(shown, run / "rods.gsd")
    with hoomd.open(str(path), "r") as frames:
        assert len(frames) == FRAMES and frames[3].particles.types == ["cell", "sensors"]
        for number, frame in enumerate(frames):
            beads = np.concatenate([rods.positions(number).reshape(-1, 3) for rods in shown.rods])
            assert frame.configuration.step == number and frame.log["time"] == pytest.approx(TIMES[number])
            near(frame.particles.position, beads)
            assert (np.abs(beads) <= frame.configuration.box[:3] / 2).all()
        bonds = frames[5].bonds.group
        assert len(bonds) == 2 * 16 + 4 * 8 and {tuple(b) for b in np.diff(bonds, axis=1)} == {(1,)}
        assert not any(first % 17 == 16 for first, _ in bonds if first < 34)  # no bond from one rod to the next
        near(frames[5].particles.diameter, np.repeat([2 * rods.radius for rods in shown.rods], [34, 36]))
        assert frames[5].log["particles/rod"][[0, 16, 17, 34, 69]].tolist() == [0, 0, 1, 2, 5]
        density = np.concatenate([rods.values(2).ravel() for rods in shown.rods])
        near(frames[2].log["particles/energy_density"], density)


def test_gsd_keeps_paths_across_a_periodic_box(tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd", reason="gsd is not installed: pip install 'warp-rods[files]'")
    write_periodic(tmp_path)
    path, shown = EXPORTERS["gsd"].export(tmp_path), content(tmp_path)
    with hoomd.open(str(path), "r") as frames:
        for number, frame in enumerate(frames):
            beads, box = frame.particles.position, frame.configuration.box[:3]
            assert box == pytest.approx([2.0, 2.5, 3.0]) and (np.abs(beads) <= box / 2 + 1e-6).all()
            whole = beads + frame.particles.image * box
            near(whole, saved(shown, 0)[number].reshape(-1, 3))
            assert frame.particles.image.any()  # the cells are beside the box


def test_mdanalysis_reads_gsd(run, shown):
    analysis = pytest.importorskip("MDAnalysis", reason="MDAnalysis is not installed")
    universe = analysis.Universe(str(EXPORTERS["gsd"].write(shown, run / "rods.gsd")))
    assert universe.trajectory.n_frames == FRAMES and len(universe.bonds) == 64
    last = shown.rods[0].positions(FRAMES - 1)
    universe.trajectory[FRAMES - 1]
    near(universe.atoms.positions[:34], last.reshape(-1, 3))


def test_simularium_reads_fibres(run, shown):
    pytest.importorskip("simulariumio", reason="simulariumio is not installed: pip install 'warp-rods[test]'")
    from simulariumio import InputFileData, UnitData
    from simulariumio.readers import SimulariumBinaryReader

    path = EXPORTERS["simularium"].write(shown, run / "rods.simularium")
    assert path.stat().st_size == pytest.approx(EXPORTERS["simularium"].estimate(shown), abs=3e3)
    read = SimulariumBinaryReader.load_binary(InputFileData(str(path)))
    about, frames = read["trajectoryInfo"], read["spatialData"]["bundleData"]
    assert about["totalSteps"] == len(frames) == FRAMES and about["spatialUnits"]["name"] == "µm"
    assert {row["name"] for row in about["typeMapping"].values()} == {"cell", "sensors"}
    assert UnitData.from_dict(about["timeUnits"]) == UnitData("ms")
    unit = about["spatialUnits"]["magnitude"] / 2.5  # of the file, in units of the scene
    assert max(about["size"].values()) == pytest.approx(100.0)
    for number, frame in enumerate(frames):
        assert frame["time"] == pytest.approx(TIMES[number])
        values, at, ids = np.asarray(frame["data"], dtype=float), 0, []
        for kind, rods in enumerate(shown.rods):
            for rod in rods.positions(number):
                head = values[at : at + 11]
                assert head[0] == 1001 and head[2] == kind and head[9] * unit == pytest.approx(rods.radius)
                ids.append(head[1])
                points = values[at + 11 : at + 11 + int(head[10])].reshape(-1, 3)
                near(points * unit, rod)
                at += 11 + int(head[10])
        assert at == len(values) and len(set(ids)) == 6


def test_without_units_no_file_claims_any(tmp_path):
    write_run(tmp_path)
    bare = content(tmp_path)
    wcon = json.loads(EXPORTERS["wcon"].export(tmp_path).read_text(encoding="utf-8"))
    assert bare.seconds is None and set(wcon["units"].values()) == {"1"}
    text = EXPORTERS["simularium"].export(tmp_path).read_bytes().decode("latin-1")
    about, _ = json.JSONDecoder().raw_decode(text[text.index("{") :])
    assert about["timeUnits"] == {"magnitude": 1.0, "name": ""} and about["spatialUnits"]["name"] == ""


def test_wcon_obeys_the_published_schema(run, shown):
    """The schema of the Tracker Commons: units; each record an id, times, and as many rows of x and of y."""
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed: pip install 'warp-rods[test]'")
    path = EXPORTERS["wcon"].write(shown, run / "rods.wcon")
    file = json.loads(path.read_text(encoding="utf-8"))
    jsonschema.validate(file, WCON)
    assert file["units"] == {"t": "0.001*s", "x": "2.5*um", "y": "2.5*um", "z": "2.5*um"}
    own = [record for record in file["data"] if record["id"] == "sensors 2"]
    assert [record["t"] for record in own] == [[pytest.approx(time)] for time in TIMES]
    for axis, letter in enumerate("xyz"):
        found = np.array([record[letter][0] for record in own])
        near(found, saved(shown, 1)[:, 2, :, axis])
    lost = [record["x"][0] for record in file["data"] if record["id"] == "sensors 1"]
    assert None not in lost[FAILED - 1] and lost[FAILED] == [None] * 9


_NUMBERS = {"type": "array", "items": {"type": ["number", "null"]}}
_ROWS = {"anyOf": [_NUMBERS, {"type": "array", "items": _NUMBERS}]}
WCON = {
    "$schema": "http://json-schema.org/draft-07/schema",
    "type": "object",
    "required": ["units", "data"],
    "properties": {
        "units": {"type": "object", "required": ["t", "x", "y"], "additionalProperties": {"type": "string"}},
        "metadata": {
            "type": "object",
            "properties": {
                "id": {"type": "string"},
                "software": {
                    "type": "object",
                    "properties": {
                        "tracker": {
                            "type": "object",
                            "properties": {"name": {"type": "string"}, "version": {"type": "string"}},
                        }
                    },
                },
            },
        },
        "data": {
            "type": "array",
            "items": {
                "type": "object",
                "required": ["id", "t", "x", "y"],
                "properties": {"id": {"type": "string"}, "t": _NUMBERS, "x": _ROWS, "y": _ROWS},
            },
        },
    },
}
"""What https://github.com/openworm/tracker-commons/blob/master/wcon_schema.json asks of the parts that we write."""


def test_pandas_reads_the_table(run, shown):
    import pandas as pd

    path = EXPORTERS["csv"].write(shown, run / "rods.csv")
    table = pd.read_csv(path)
    assert list(table) == ["frame", "time", "ensemble", "rod", "node", "s", "x", "y", "z", "energy_density"]
    assert len(table) == FRAMES * (2 * 17 + 4 * 9)
    sensors = table[table.ensemble == "sensors"]
    places = sensors[["x", "y", "z"]].to_numpy().reshape(FRAMES, 4, 9, 3)
    near(places, saved(shown, 1), 1e-8)
    data = shown.rods[1].data
    density = data["energy_density"].where(data["status"] == 0).values
    near(sensors.energy_density.to_numpy().reshape(FRAMES, 4, 9), density, 1e-8)
    assert sensors[(sensors.frame >= FAILED) & (sensors.rod == 1)].x.isna().all() and sensors.x.isna().sum() == 2 * 9
    assert sensors.s[sensors.node == 8].unique() == pytest.approx([0.5])
    assert table.time.unique() == pytest.approx(TIMES)


@pytest.mark.parametrize("name", FILES)
def test_sizes_are_foretold_and_nothing_half_written_is_left(run, shown, tmp_path, name):
    made = EXPORTERS[name].write(shown, tmp_path / EXPORTERS[name].file_name)
    size = sum(file.stat().st_size for file in (made.iterdir() if made.is_dir() else [made]))
    assert size / 2 < EXPORTERS[name].estimate(shown) < 2 * size
    broken = content(run)
    broken.rods[-1].data = None
    with pytest.raises((TypeError, AttributeError)):
        EXPORTERS[name].write(broken, tmp_path / f"own{EXPORTERS[name].suffix}")
    assert list(tmp_path.iterdir()) == [made]


@pytest.mark.parametrize(("name", "package"), [("vtkhdf", "h5py"), ("gsd", "gsd")])
def test_a_package_that_is_missing_is_named_with_the_extra(run, tmp_path, name, package, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "h5py" if name == "vtkhdf" else "gsd.hoomd", None)
    with pytest.raises(WarpRodsError, match=rf"--{name} needs the package {package}.*pip install -e '\.\[files\]'"):
        EXPORTERS[name].export(run, tmp_path / EXPORTERS[name].file_name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", [*FILES[1:], "microscope"])
def test_frames_go_forward_in_files(run, tmp_path, name):
    row = EXPORTERS[name]
    with pytest.raises(SceneError, match="step of frames = -1: must be positive"):
        row.export(run, tmp_path / row.file_name, Selection(frames=slice(None, None, -1)))
    assert list(tmp_path.iterdir()) == []
    assert row.export(run, tmp_path / row.file_name, Selection(frames=slice(3, 2, -1))).exists()  # one frame


def test_chosen_ensembles_and_frames_are_written(run, tmp_path):
    import pandas as pd

    chosen = Selection(("cell",), slice(1, None, 2), "speed")
    table = pd.read_csv(EXPORTERS["csv"].export(run, tmp_path / "own.csv", chosen))
    assert table.frame.unique().tolist() == [1, 3, 5] and set(table.ensemble) == {"cell"} and "speed" in table
