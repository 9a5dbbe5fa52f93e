"""Pictures made of characters."""

import numpy as np
import pytest

from warp_rods.draw import characters


def test_a_sparkline_goes_from_the_lowest_to_the_highest_bar():
    assert characters.sparkline(np.arange(8), 8) == "▁▂▃▄▅▆▇█"
    assert characters.sparkline(np.repeat(np.arange(8), 5), 8) == "▁▂▃▄▅▆▇█"
    assert characters.sparkline([1.0, np.nan, 2.0], 9) == "▁ █"
    assert characters.sparkline([3.0, 3.0], 9) == "▁▁" and characters.sparkline([], 9) == ""
    assert characters.sparkline([0.0, 1.0], 9, plain=True).isascii()


def test_dots_are_those_of_braille():
    """The dots of a character have the numbers 1 to 8 of Unicode: 1, 2, 3, 7 on the left, 4, 5, 6, 8 on the right."""
    for (column, row), dot in {(0, 0): 1, (0, 1): 2, (0, 2): 3, (1, 0): 4, (1, 2): 6, (0, 3): 7, (1, 3): 8}.items():
        assert characters.canvas(np.array([[column, row]]), 1, 1) == [chr(0x2800 + (1 << (dot - 1)))]
    every = np.stack(np.meshgrid(np.arange(-1, 9), np.arange(-1, 9)), -1).reshape(-1, 2)
    assert characters.canvas(every, 2, 1) == ["⣿⣿"]
    assert characters.canvas(np.array([[3, 5]]), 2, 2, plain=True) == ["  ", " #"]


def test_a_diagonal_rod_goes_from_corner_to_corner():
    rod = np.array([[[0.0, 0.0], [1.0, 1.0]]])
    dots = characters.dots_along(rod, 4, 2)  # 8 by 8 dots
    np.testing.assert_array_equal(dots, [[i, 7 - i] for i in range(8)])  # up is up


def test_all_directions_have_one_scale():
    half_circle = np.stack([np.cos(np.linspace(0, np.pi, 99)), np.sin(np.linspace(0, np.pi, 99))], -1)[None]
    dots = characters.dots_along(half_circle, 20, 10)
    assert np.ptp(dots[:, 0]) == 39 and np.ptp(dots[:, 1]) in (19, 20)


@pytest.mark.parametrize("value", [0.0, 1e-300, 7e20])
def test_rods_of_no_extent_are_a_dot(value):
    assert len(characters.dots_along(np.full((2, 5, 2), value), 10, 5)) == 1


def test_rods_are_seen_along_the_axis_of_least_extent_and_within_their_box():
    position = np.zeros((1, 5, 3))
    position[..., 2], position[..., 0] = np.arange(5), np.arange(5) / 2
    rods, axes = characters.projected(position)
    assert axes == "zx"
    np.testing.assert_array_equal(rods[0, :, 0], np.arange(5))
    moved, _ = characters.projected(position + np.array([0, 0, 40]), np.array([np.inf, np.inf, 10.0]))
    np.testing.assert_array_equal(moved, rods)
    beyond, _ = characters.projected(position + np.array([0, 0, 5]), np.array([np.inf, np.inf, 10.0]))
    np.testing.assert_array_equal(beyond[0, :, 0], np.arange(5) - 5)  # the box is from -5 to 5, as in pictures
