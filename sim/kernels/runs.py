"""Runs of pairs of elements: (a, b), (a + 1, b + 1) and so on, which lie side by side in memory.

A table of runs (4, room) holds in each column the first a, the first b, the number of that pair in
the list and how many pairs there are; a run of none ends it.
"""

from sim.kernels.compiled import formula, kernel

LANES = 8  # doubles in the widest vector register
LONGEST = 64  # pairs in a run
STRIDE = LONGEST + 8  # of rows in the work space; no power of two, see `sim.kernels.layout`

FIRST_A, FIRST_B, NUMBER, LENGTH_OF = range(4)


@formula
def natural(i):
    """Return the index i, which the compiler then knows not to count from the end of an array."""
    return i & 0x7FFFFFFF


@formula
def whole(count):
    """Return how many columns the vectors have that hold `count` of them."""
    return natural(count + LANES - 1) & -LANES


@formula
def bounds(runs, run):
    """Return the first elements, the first number and the length of a run."""
    return (
        natural(runs[FIRST_A, run]),
        natural(runs[FIRST_B, run]),
        natural(runs[NUMBER, run]),
        natural(runs[LENGTH_OF, run]),
    )


@kernel
def prolong(runs, last, a, b, number):
    """Add a pair to the last run, or begin another one with it; return which is the last.

    A run along one strand stays shorter than b - a: no node is on both of its sides, and the order
    of the sums at a node is that of the pairs.
    """
    if last >= 0:
        length = runs[LENGTH_OF, last]
        follows = a == runs[FIRST_A, last] + length and b == runs[FIRST_B, last] + length
        if follows and length < min(LONGEST, b - a - 1):
            runs[LENGTH_OF, last] = length + 1
            return last
    last += 1
    runs[FIRST_A, last], runs[FIRST_B, last] = a, b
    runs[NUMBER, last], runs[LENGTH_OF, last] = number, 1
    return last


@kernel
def fill_runs(pairs, runs):
    """Put all pairs together to runs; return how many there are."""
    last = -1
    for k in range(pairs.shape[1]):
        last = prolong(runs, last, pairs[0, k], pairs[1, k], k)
    runs[LENGTH_OF, last + 1] = 0
    return last + 1
