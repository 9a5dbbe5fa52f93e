"""Random numbers without a state: Philox4x32-10 (Salmon, Moraes, Dror and Shaw 2011, "as easy as 1, 2, 3").

A counter of four words and a key of two give four words. Equal counters and keys give equal words, on every device.
"""

import warp as wp

from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

Words = wp.types.vector(length=4, dtype=wp.uint32)

ROUNDS = wp.constant(10)
FIRST_FACTOR, SECOND_FACTOR = wp.constant(wp.uint64(0xD2511F53)), wp.constant(wp.uint64(0xCD9E8D57))
FIRST_WEYL, SECOND_WEYL = wp.constant(wp.uint32(0x9E3779B9)), wp.constant(wp.uint32(0xBB67AE85))
"""What is added to the words of the key after each round."""
PER_WORD, PER_TWO_WORDS = wp.constant(real(2.0**-32)), wp.constant(real(2.0**-53))


@wp.func
def high_word(x: wp.uint64) -> wp.uint32:
    """The upper 32 bits."""
    return wp.uint32(x >> wp.uint64(32))


@wp.func
def low_word(x: wp.uint64) -> wp.uint32:
    """The lower 32 bits."""
    return wp.uint32(x & wp.uint64(0xFFFFFFFF))


@wp.func
def philox(counter: Words, key: wp.uint64) -> Words:
    """Four random words; the first word of the key is the lower one."""
    x = counter
    first, second = low_word(key), high_word(key)
    for _round in range(ROUNDS):
        p, q = FIRST_FACTOR * wp.uint64(x[0]), SECOND_FACTOR * wp.uint64(x[2])
        x = Words(high_word(q) ^ x[1] ^ first, low_word(q), high_word(p) ^ x[3] ^ second, low_word(p))
        first += FIRST_WEYL
        second += SECOND_WEYL
    return x


@wp.func
def uniform(word: wp.uint32) -> real:
    """A number in (0, 1) from a word, of 32 bits."""
    return (real(word) + real(0.5)) * PER_WORD


@wp.func
def uniform_of_two(first: wp.uint32, second: wp.uint32) -> real:
    """A number in (0, 1) from two words, of 52 bits."""
    bits = (wp.uint64(first) << wp.uint64(20)) | (wp.uint64(second) >> wp.uint64(12))
    return real(2.0) * (real(bits) + real(0.5)) * PER_TWO_WORDS
