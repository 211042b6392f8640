"""What is refused, and in which words."""

from contextlib import contextmanager

import pytest

from hpc_gfmd.util.errors import SceneError


@contextmanager
def refused(words, error=SceneError):
    """What stands below is refused in one line, in which the pattern `words` is found."""
    with pytest.raises(error, match=words) as caught:
        yield
    assert str(caught.value).isprintable()
