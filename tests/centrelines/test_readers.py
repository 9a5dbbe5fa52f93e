"""Files of centre lines, written by hand as other programs write them, and what is refused."""

import json
import zipfile

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.centrelines.readers import CHOICES, READERS, read_track
from warp_rods.centrelines.track import TrackError, metres_of
from warp_rods.errors import SceneError

XY = np.array([[0.0, 0.5], [1.0, 0.25], [2.0, -1.5], [3.5, 1e-3], [4.0, 2.0]])


def read(path, **choice):
    return read_track(path, choice)


@pytest.mark.parametrize(
    "suffix, text",
    [
        (".csv", "0,0.5\n1,0.25\n2,-1.5\n3.5,1e-3\n4,2\n"),
        (".csv", "x,y\n0,0.5\n1,0.25\n2,-1.5\n3.5,1e-3\n4,2\n"),
        (".csv", "\ufeffid,Y (mm),X (mm)\na,0.5,0\nb,0.25,1\nc,-1.5,2\nd,1e-3,3.5\ne,2,4\n"),
        (".csv", "x;y\r\n0;0,5\r\n1;0,25\r\n2;-1,5\r\n3,5;1e-3\r\n4;2\r\n"),
        (
            ".tsv",
            "# a tracker\nPOSITION_X\tPOSITION_Y\tQUALITY\n0\t0.5\t\n1\t0.25\t9\n2\t-1.5\t\n3.5\t1e-3\t\n4\t2\t\n",
        ),
        (".txt", "  0 0.5\n 1 0.25\n\n 2 -1.5\n 3.5 1e-3\n 4 2"),
        (".dat", '"x","y"\n"0","0.5"\n"1","0.25"\n"2","-1.5"\n"3.5","1e-3"\n"4","2"\n'),
    ],
)
def test_tables_of_text(tmp_path, suffix, text):
    (tmp_path / f"track{suffix}").write_text(text, encoding="utf-8", newline="")
    track = read(tmp_path / f"track{suffix}")
    np.testing.assert_array_equal(track.points, XY)
    assert track.metres == (1e-3 if "mm" in text else None)


def test_empty_cells_of_a_table_are_missing_points(tmp_path):
    (tmp_path / "a.csv").write_text("x,y,z\n1,2,3\n4,,6\nnan,1,1\n7,8\n")
    np.testing.assert_array_equal(np.isnan(read(tmp_path / "a.csv").points).sum(axis=1), [0, 1, 1, 1])


def test_frames_of_a_table(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("frame,x,y\n7,1,2\n3,3,4\n7,5,6\n3,7,8\n")
    np.testing.assert_array_equal(read(file, frame=0).points, [[3, 4], [7, 8]])
    np.testing.assert_array_equal(read(file, frame=-1).points, read(file, time=7.0).points)
    with pytest.raises(TrackError, match="has 2 frames, at the times 3, 7: choose one by frame"):
        read(file)


def test_arrays(tmp_path):
    np.save(tmp_path / "a.npy", XY)
    np.save(tmp_path / "b.npy", np.stack([XY, XY + 1], axis=0))
    np.testing.assert_array_equal(read(tmp_path / "a.npy").points, XY)
    np.testing.assert_array_equal(read(tmp_path / "b.npy", frame=-1).points, XY + 1)
    np.save(tmp_path / "c.npy", np.array([{"x": 1}], dtype=object), allow_pickle=True)
    for name, choice, said in (
        ("b", {}, "has 2 frames"), ("a", {"frame": 0}, "has one line only"), ("c", {}, "is no array of numbers"),
        ("b", {"time": 1.0}, "time = 1.0: not a choice in a .npy file, where lines are chosen by frame"),
        ("a", {"worm": 1}, "worm = 1: not a choice in a .npy file"),
    ):  # fmt: skip
        with pytest.raises(TrackError, match=said):
            read(tmp_path / f"{name}.npy", **choice)


WCON = {
    "units": {"t": "s", "x": "mm", "y": "mm", "ox": "mm", "oy": "mm"},
    "metadata": {"strain": "N2"},
    "data": [
        {"id": 1, "t": [1.3, 1.5], "x": [[12.15, 13.0], [12.0, 12.95]], "y": [[2.34, 2.74], [2.37, None]], "head": "L"},
        {"id": "2", "t": 1.4, "x": [22.0, 22.5, 23.0], "y": [8.0, 8.9, 9.0], "head": "R", "ox": 100, "oy": -10},
        {"id": 1, "t": 1.4, "x": [1.0, 2.0], "y": [0.5, 0.75], "cx": 10, "cy": 20, "@XJ": {"any": 1}},
    ],
}


def test_wcon(tmp_path):
    """Arrays and single times, the same worm in several entries, origins, the head at the end, and missing points."""
    file = tmp_path / "worms.wcon"
    file.write_text(json.dumps(WCON))
    np.testing.assert_array_equal(read(file, worm=1, frame=0).points, [[12.15, 2.34], [13.0, 2.74]])
    np.testing.assert_array_equal(read(file, worm="1", time=1.41).points, [[11.0, 20.5], [12.0, 20.75]])
    np.testing.assert_array_equal(read(file, worm=1, frame=-1).points, [[12.0, 2.37], [12.95, np.nan]])
    track = read(file, worm="2")
    np.testing.assert_allclose(track.points, [[123.0, -1.0], [122.5, -1.1], [122.0, -2.0]], rtol=1e-15)
    assert track.metres == 1e-3 and track.chosen == "worm 2 at time 1.4"
    with zipfile.ZipFile(tmp_path / "worms.wcon.zip", "w") as archive:
        archive.write(file, "worms.wcon")
    np.testing.assert_array_equal(read(tmp_path / "worms.wcon.zip", worm="2").points, track.points)
    for choice, said in (
        ({}, "has the worms 1, 2: choose one by worm"), ({"worm": 3}, "worm = 3: has the worms 1, 2"),
        ({"worm": 1}, "has 3 frames, at the times 1.3, 1.4, 1.5"),
        ({"worm": 1, "time": 9.0}, "time = 9: has the times"),
        ({"worm": 1, "frame": 3}, "frame = 3: has 3 frames, 0 to 2"),
    ):  # fmt: skip
        with pytest.raises(TrackError, match=said):
            read(file, **choice)


@pytest.mark.parametrize("text, said", [
    ("{", "is no JSON"), ("[1]", "is no WCON"), ('{"units": {}, "data": [{"id": 1}]}', "its data cannot be read"),
    ('{"data": [{"id": 1, "t": [1, 2], "x": [[1, 2]], "y": [[1, 2]]}]}', "1 rows of points for 2 times"),
    ('{"data": []}', "has no worms"),
    ('{"data": {"id": 1, "t": [1, 2], "x": [[null], [1, 2]], "y": [[null], [1, 2]]}}', "frames with points: 1"),
])  # fmt: skip
def test_what_is_no_wcon_is_refused(tmp_path, text, said):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(TrackError, match=said):
        read(tmp_path / "a.json", frame=0)


SWC = """# a neurite
# id type x y z r parent
1 1 0 0 0 5.0 -1
2 3 1 0 0 1.0 1
 3 3 2 0 0.5 1.0 2
4 3 3 1 0 0.5 3
7 3 3 -1 0 0.5 3
9 3 4 -2 0 0.5 7
"""


def test_paths_of_trees(tmp_path):
    file = tmp_path / "cell.swc"
    file.write_text(SWC)
    track = read(file, branch=9)
    np.testing.assert_array_equal(track.points, [[0, 0, 0], [1, 0, 0], [2, 0, 0.5], [3, -1, 0], [4, -2, 0]])
    assert track.chosen == "from 1 to the tip 9"
    with pytest.raises(TrackError, match="has 2 tips, with the ids 4, 9: choose one by branch"):
        read(file)
    with pytest.raises(TrackError, match="branch = 3: must be the id of a tip, one of 4, 9"):
        read(file, branch=3)
    (tmp_path / "line.swc").write_text("\n".join(SWC.splitlines()[:6]))
    assert len(read(tmp_path / "line.swc").points) == 4


@pytest.mark.parametrize("text, said", [
    ("", "has no nodes"), ("1 1 0 0 0 1\n", "line 1: must be the numbers id, type"),
    ("1 1 0 0 0 1 -1\n1 1 0 0 0 1 -1", "the id 1 is there twice"),
    ("1 1 0 0 0 1 2\n2 1 0 0 0 1 1\n3 1 0 0 0 1 2", "the parents of 3 form a loop"),
    ("2 1 0 0 0 1 1", "the parent 1 of 2 is missing"),
])  # fmt: skip
def test_what_is_no_tree_is_refused(tmp_path, text, said):
    (tmp_path / "a.swc").write_text(text)
    with pytest.raises(TrackError, match=said):
        read(tmp_path / "a.swc")


@pytest.mark.parametrize("text, said", [
    ("", "is empty"), ("1,2,3,4\n", "has 4 columns and no header"), ("a,b\n1,2\n", "has no column for x"),
    ("x1,x2,x,x,y\n1,2,3,4,5\n", "has two columns for x"), ("x,y\n1,2\n3,wide\n", "row 2 of its numbers has 'wide' in"),
    ("x,y\n1,2\n", "no column named frame"), ("frame,x,y\n", "has no numbers in the column frame"),
])  # fmt: skip
def test_what_is_no_table_is_refused(tmp_path, text, said):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(TrackError, match=said):
        read(tmp_path / "a.csv", frame=0)


def test_bytes_that_are_no_text_and_folders_are_refused(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe\x00\x01\x80")
    (tmp_path / "b.csv").mkdir()
    for name, said in (("a", "is no text"), ("b", "cannot be read")):
        with pytest.raises(SceneError, match=said):
            wr.from_centreline(tmp_path / f"{name}.csv")


@pytest.mark.parametrize("unit, metres", [
    ("mm", 1e-3), ("millimeters", 1e-3), ("µm", 1e-6), ("microns", 1e-6), ("metre", 1.0), ("12*in", 0.3048),
    ("in/72", 0.0254 / 72), ("0.65*um", 0.65e-6), ("px", None), ("1", None), ("mm*mm", None), ("s", None), (3, None),
    ("um/0", None),
])  # fmt: skip
def test_units_of_length(unit, metres):
    assert metres_of(unit) == (None if metres is None else pytest.approx(metres))


def test_every_format_has_words_and_known_choices():
    assert all(row.words and set(row.choices) <= set(CHOICES) for row in READERS.values())
    assert {choice for row in READERS.values() for choice in row.choices} == set(CHOICES)
