"""A context manager for calls that have to be refused."""

from contextlib import contextmanager

import pytest

from hpc_gfmd.util.errors import SceneError


@contextmanager
def refused(words, error=SceneError):
    """Require an error whose message is one line that matches the pattern `words`."""
    with pytest.raises(error, match=words) as caught:
        yield
    assert str(caught.value).isprintable()
