"""Ends of free rods that move along a table of times and points."""

import re

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.centrelines.table import read_array, read_motion, read_table
from warp_rods.centrelines.track import TrackError
from warp_rods.errors import SceneError
from warp_rods.rods.free.motion import Motion
from warp_rods.rods.free.rods import FreeRods


def read_table_or_array(path):
    """As centre lines are read."""
    return read_array(path) if path.suffix == ".npy" else read_table(path)


FORMULAS = ["0.1*sin(2*t)", 0, "0.2*t"]
ROD = {"bend": 1e-2, "twist": 1e-2, "flagella": None, "shape": {"kind": "straight"}}


def points(times):
    return np.stack([0.1 * np.sin(2 * times), 0 * times, 0.2 * times], axis=1)


def table(count, start=0.0, end=2.0):
    times = np.linspace(start, end, count)
    return {"times": times, "points": points(times)}


def clamp(motion):
    return ({"kind": "clamped", "motion": motion}, "free")


def test_the_spline_is_of_fourth_order_and_its_velocity_of_third(verified):
    at = np.linspace(0, 2, 301)
    exact, errors = points(at), []
    rate = np.stack([0.2 * np.cos(2 * at), 0 * at, 0.2 + 0 * at], axis=1)
    for count in (11, 21, 41, 81):
        motion = Motion("m", table(count), {}, True)
        found = np.array([motion(t) for t in at])
        slopes = np.array([motion.rate(t) for t in at])
        errors.append((abs(found - exact).max(), abs(slopes - rate).max()))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    for name, order, k in (("place", 4, 0), ("velocity", 3, 1)):
        verified(
            "orders", f"end moved along a table: {name}, in the spacing of its times", measured=orders[-1, k],
            expected=order, within=0.35, reference="spacings halved three times",
        )  # fmt: skip


def test_a_rod_moved_along_a_table_moves_as_by_its_formula():
    """The table of a formula at 41 times; also what the end does at the start, where velocities are one-sided."""
    rods = [FreeRods(1, 17, **ROD, ends=clamp(motion)) for motion in (FORMULAS, table(11), table(41))]
    for one in rods:
        one.step(1e-2, 100)
    exact, coarse, fine = (one.position[0] for one in rods)
    errors = [abs(found - exact).max() for found in (coarse, fine)]
    assert errors[1] < 1e-5 and errors[0] / errors[1] > 4**3
    np.testing.assert_allclose(
        fine[0] - points(np.array([1.0]))[0], rods[0].position[0, 0] - points(np.array([1.0]))[0], atol=1e-6
    )


def test_tables_go_straight_on_beyond_their_ends_or_repeat():
    straight = Motion("m", table(21, -1.0, 1.0), {}, True)
    for time, end in ((5.0, 1.0), (-3.0, -1.0)):
        rate = np.array([0.2 * np.cos(2 * end), 0.0, 0.2])
        np.testing.assert_allclose(straight.rate(time), rate, atol=1e-3)
        np.testing.assert_allclose(straight(time), points(np.array([end]))[0] + (time - end) * rate, atol=3e-3)
    np.testing.assert_array_equal(straight(0.0), 0.0)
    times = np.linspace(0, 2, 41)
    wave = np.stack([np.cos(np.pi * times), 0 * times, 0 * times], axis=1)
    wave[-1] = wave[0]
    motion = Motion("m", {"times": times, "points": wave, "periodic": True}, {}, True)
    np.testing.assert_allclose(motion(7.3)[0], np.cos(np.pi * 7.3) - 1, atol=1e-4)


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_velocities_are_exact_in_any_unit_of_time(unit):
    """Of formulas, also with parameters of each rod, of tables, and of rotation vectors."""
    w, t = 1 / unit, 0.3 * unit
    speed = 0.1 * w * np.cos(w * t)
    motion = Motion("m", [f"0.1*sin({w!r}*t)", "-k*atan2(t, t**2)", "exp(k*0)"], {"k": np.array([1.0, 2.0])}, True)
    expected = [[speed, -k * (t**2 - 2 * t**2) / (t**2 + t**4), 0.0] for k in (1.0, 2.0)]
    np.testing.assert_allclose(motion.rate(t), expected, rtol=1e-12)
    given = table(201)
    of_table = Motion("m", {"times": given["times"] * unit, "points": given["points"]}, {}, True)
    np.testing.assert_allclose(of_table.rate(t)[0], 2 * speed * np.cos(2 * w * t) / np.cos(w * t), rtol=1e-4)


def test_a_turned_end_starts_as_it_is_and_turns_by_its_rotation():
    """R(t) R(0)⁻¹, with the angular velocity of the derivative of R; also where the vector is not 0 at t = 0."""
    from scipy.spatial.transform import Rotation

    def vector(t):
        return np.array([0.4 + np.sin(t), 0.5, 0.3 * t])

    ends = ({"kind": "clamped", "rotation": ["0.4 + sin(t)", 0.5, "0.3*t"]}, "free")
    holding = FreeRods(1, 17, **ROD, ends=ends)._holding
    first, h = holding._at(0, 0.0)[1][0], 1e-5
    np.testing.assert_allclose(first, np.eye(3), atol=1e-15)
    for t in (0.0, 0.7):
        turns = [Rotation.from_rotvec(vector(t + d)) for d in (-h, h)]
        turned = Rotation.from_rotvec(vector(t)) * Rotation.from_rotvec(vector(0.0)).inv()
        np.testing.assert_allclose(holding._at(0, t)[1][0], turned.as_matrix(), atol=1e-14)
        rate = (turns[1] * turns[0].inv()).as_rotvec() / (2 * h)
        np.testing.assert_allclose(holding._rates(0, t)[1][0], rate, rtol=1e-8, atol=1e-9)


def scene(motion, end=2.0):
    ends = [{"kind": "clamped", "motion": motion}, "free"]
    cell = {"name": "cell", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-2, "ends": ends}
    return {"swimmers": [cell], "time": {"end": end}}


def test_files_of_motions(tmp_path):
    """The numbers are in the scene from then on, so that a run does not need the file any more."""
    times = table(21)["times"]
    rows = [f"{t!r};{x!r};{y!r};{z!r}" for t, (x, y, z) in zip(times.tolist(), points(times).tolist(), strict=True)]
    (tmp_path / "track.csv").write_text("time;x;y;z\n" + "\n".join(rows))
    np.save(tmp_path / "track.npy", np.column_stack([times, points(times)]))
    given = wr.Scene(**scene(table(21)))
    for name in ("track.csv", "track.npy"):
        made = wr.Scene(**scene({"file": str(tmp_path / name)}))
        assert made == given and wr.Scene.parse(made.to_toml()) == given
    file = tmp_path / "scene.toml"
    file.write_text(
        '[[swimmers]]\nname = "cell"\ncount = 1\nnodes = 17\nbend = 1e-2\ntwist = 1e-2\n'
        'ends = [{ kind = "clamped", motion = { file = "track.csv" } }, "free"]\n[time]\nend = 2.0\n'
    )
    assert wr.Scene.load(file) == given


@pytest.mark.parametrize(("motion", "line"), [
    (table(21, 0, 1.5), "swimmers[0].ends[0]: a table of its motion ends at 1.5, before time.end = 2"),
    (table(21, 0.1), "ends[0].motion.times = [0.1, "),
    (table(3), "must be a list of 4 or more increasing times"),
    ({"times": [0, 1, 2, 3], "points": [[0, 0, 0]] * 3}, "motion.points: has 3 points; needs one for each of 4 times"),
    ({"times": [0, 1, 2, 3]}, "motion: points: missing; give times and points, or a file"),
    ({"file": "nowhere.csv"}, "motion.file: there is no file nowhere.csv"),
    ({"file": "/"}, "motion.file = \"/\": cannot be read: Is a directory"),
    (table(21) | {"periodic": True}, "the first and the last must be equal where periodic = true"),
    (table(21) | {"every": 1}, "motion.every: unknown key"),
])  # fmt: skip
def test_mistakes_in_tables_are_named(motion, line):
    with pytest.raises(SceneError) as caught:
        wr.Scene(**scene(motion))
    assert line in str(caught.value)


def test_an_empty_file_is_no_array(tmp_path):
    (tmp_path / "track.npy").write_bytes(b"")
    with pytest.raises(SceneError, match=r"track\.npy is no array of numbers"):
        wr.Scene(**scene({"file": str(tmp_path / "track.npy")}))


def test_columns_of_a_motion_are_those_with_exact_names(tmp_path):
    (tmp_path / "track.csv").write_text("t,v_x,v_y,v_z,x,y,z\n0,9,9,9,0,0,0\n1,9,9,9,1,2,3\n")
    np.testing.assert_array_equal(read_motion(tmp_path / "track.csv")["points"][1], [1.0, 2.0, 3.0])


@pytest.mark.parametrize(("name", "content", "words"), [
    ("a.csv", "t,v_x,v_y,x_0,y\n0,1,2,3,4\n", "two columns for x"),
    ("a.csv", "t (ms),x (um),y,z\n0,1,2,3\n", "the unit ms in the header of the column t (ms)"),
    ("a.csv", "t,x,y,z\n0,0,0,0\n1,0,5,2,5\n", "row 3 has 5 cells"),
    ("a.csv", f't,x,y,z\n0,0,0,"{"1" * 140_000}"\n', "cannot be read as a table"),
    ("a.npy", b"PK\x03\x04garbage", "is no array of numbers"),
    ("a.npy", "npz", "has several arrays"),
    ("a.npy", np.zeros((5, 4), complex), "has the type complex128"),
])  # fmt: skip
@pytest.mark.parametrize("read", [read_motion, read_table_or_array])
def test_damaged_files_of_motions_are_told(tmp_path, name, content, words, read):
    path = tmp_path / name
    if isinstance(content, np.ndarray):
        np.save(path, content)
    elif content == "npz":
        np.savez(tmp_path / "a.npz", a=np.zeros(3))
        (tmp_path / "a.npz").rename(path)
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    if read is read_table_or_array and ("unit" in words or "two columns" in words):
        pytest.skip("centre lines have units")
    with pytest.raises(TrackError, match=re.escape(words)):
        read(path)


def test_a_periodic_table_closes_up_to_round_off():
    times = np.linspace(0, 2, 41)
    wave = np.stack([np.sin(np.pi * times), np.cos(np.pi * times), 0 * times], axis=1)
    assert wave[0, 0] != wave[-1, 0]
    motion = Motion("m", {"times": times, "points": wave, "periodic": True}, {}, True)
    np.testing.assert_allclose(motion(2.5), [1.0, -1.0, 0.0], atol=1e-4)


def test_a_curve_through_uneven_times_rests_where_its_points_rest():
    """A spline between such points goes as far as −6.8."""
    times = [0, 2, 2.1, 2.2, 4]
    pulse = Motion("m", {"times": times, "points": [[0, 0.1 * (t == 2.1), 0] for t in times]}, {}, True)
    found = np.array([pulse(t)[1] for t in np.linspace(0, 4, 801)])
    assert found.min() == 0.0 and found.max() == pytest.approx(0.1, rel=1e-9)
    assert (found[:401] == 0).all() and (found[441:] == 0).all()


PULSE = "0.05*exp(-((t - 0.15)/0.002)**2)"


@pytest.mark.parametrize("kind", ["formula", "table"])
def test_no_step_by_error_passes_over_a_motion_that_comes_after_a_rest(kind):
    times = np.linspace(0, 0.2, 401)
    points = np.stack([0 * times, 0.05 * np.exp(-(((times - 0.15) / 0.002) ** 2)), 0 * times], axis=1)
    motion = [0, PULSE, 0] if kind == "formula" else {"times": times, "points": points}
    rods = FreeRods(1, 17, **ROD, ends=clamp(motion))
    rods.advance_to(0.2)
    assert abs(rods.strain).max() == pytest.approx(0.0883, rel=0.01)  # with 4000 equal steps 0.08839
