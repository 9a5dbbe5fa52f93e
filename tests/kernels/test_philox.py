"""Philox4x32-10 against the known answers of Random123, and its numbers in (0, 1)."""

import numpy as np
import pytest
import warp as wp

from warp_rods.kernels.layout import Scalars1D
from warp_rods.kernels.philox import Words, philox, uniform, uniform_of_two

KNOWN = [
    ([0, 0, 0, 0], 0, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
    ([0xFFFFFFFF] * 4, 0xFFFFFFFFFFFFFFFF, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
    (
        [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
        0x299F31D0A4093822,
        [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
    ),
]


@wp.kernel(enable_backward=False)
def find_words(counter: wp.array(dtype=Words), key: wp.array(dtype=wp.uint64), words: wp.array(dtype=Words)):
    i = wp.tid()
    words[i] = philox(counter[i], key[i])


@wp.kernel(enable_backward=False)
def find_uniform(counter: wp.array(dtype=Words), one: Scalars1D, two: Scalars1D):
    i = wp.tid()
    word = philox(counter[i], wp.uint64(7))
    one[i] = uniform(word[0])
    two[i] = uniform_of_two(word[1], word[2])


@wp.kernel(enable_backward=False)
def find_extremes(found: Scalars1D):
    least, most = wp.uint32(0), wp.uint32(4294967295)
    found[0] = uniform(least)
    found[1] = uniform_of_two(least, least)
    found[2] = uniform(most)
    found[3] = uniform_of_two(most, most)


@pytest.mark.parametrize("row", range(len(KNOWN)))
def test_known_answers(row, device):
    counter, key, expected = KNOWN[row]
    words = wp.zeros(1, dtype=Words, device=device)
    given = [
        wp.array(np.array([counter], dtype=np.uint32), dtype=Words, device=device),
        wp.array(np.array([key], dtype=np.uint64), dtype=wp.uint64, device=device),
    ]
    wp.launch(find_words, dim=1, inputs=[*given, words], device=device)
    np.testing.assert_array_equal(words.numpy()[0], np.array(expected, dtype=np.uint32))


def test_numbers_are_uniform_and_never_0_or_1(device):
    from scipy.stats import kstest

    n = 20_000
    counters = np.zeros((n, 4), dtype=np.uint32)
    counters[:, 0] = np.arange(n)
    one, two = (wp.zeros(n, dtype=wp.float64, device=device) for _ in range(2))
    wp.launch(find_uniform, dim=n, inputs=[wp.array(counters, dtype=Words, device=device), one, two], device=device)
    assert kstest(one.numpy(), "uniform").pvalue > 1e-3 and kstest(two.numpy(), "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(one.numpy(), two.numpy())[0, 1]) < 3.3 / np.sqrt(n)
    found = wp.zeros(4, dtype=wp.float64, device=device)
    wp.launch(find_extremes, dim=1, inputs=[found], device=device)
    least, smallest, most, largest = found.numpy()
    assert 0 < smallest < least < 1e-9 and 1 - 1e-9 < most < largest < 1
