"""Errors of one rank: all ranks raise, the others with its reason, or its traceback."""

import pytest

from hpc_gfmd.parallel.guard import collective_errors
from hpc_gfmd.util.errors import GfmdError, ProgrammingError
from hpc_gfmd.util.quantities import parse

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]


def read_on_the_last_rank(comm, text):
    """Parse a text on one rank, in a block of which errors are raised on all."""
    with collective_errors(comm, "outside"), collective_errors(comm, "reading"):
        if comm.rank == comm.size - 1:
            parse(text, "length")


@pytest.mark.parametrize(
    ("text", "on_the_rank", "on_others", "words"),
    [
        ("1", GfmdError, GfmdError, "reading: it is not a number with a unit"),
        (None, TypeError, ProgrammingError, "subscriptable"),
    ],
)
def test_one_rank(text, on_the_rank, on_others, words, comm):
    kind = on_the_rank if comm.rank == comm.size - 1 else on_others
    with pytest.raises(kind, match=words):
        read_on_the_last_rank(comm, text)
