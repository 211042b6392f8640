"""The cache of compiled kernels: what is stale, damaged or somebody else's is compiled again; one that cannot be written is none.

numba looks at the source file of a kernel only, but other files' functions are compiled into it, and it trusts what it finds.
"""

import hashlib
from functools import cache
from pathlib import Path

import llvmlite
import numba
import numpy
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache


@cache
def stamp() -> str:
    """Changes with any kernel and with all that makes machine code of them."""
    digest = hashlib.sha256(" ".join((numba.__version__, llvmlite.__version__, numpy.__version__)).encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


class _File(IndexDataCacheFile):
    """Every entry knows what it is, and has a checksum: machine code with a wrong bit would run."""

    def save(self, key, data):
        content = self._dump((self._source_stamp, key, data))
        super().save(key, (hashlib.sha256(content).digest(), content))

    def load(self, key):
        found = super().load(key)
        if found is None:
            return None
        checksum, content = found
        if hashlib.sha256(content).digest() != checksum:
            return None
        stamp, known, data = numba.core.serialize.loads(content)
        return data if (stamp, known) == (self._source_stamp, key) else None


class KernelCache(FunctionCache):
    """numba's cache of one function without its exceptions."""

    def __init__(self, function):
        super().__init__(function)
        self._cache_file = _File(self._cache_path, self._impl.filename_base, stamp())

    def load_overload(self, sig, target_context):
        """The compiled function, or None if it has to be compiled."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # pickle may raise any on damaged input
            return None

    def save_overload(self, sig, data):
        """Keep it if that is possible."""
        try:
            super().save_overload(sig, data)
        except Exception:  # a damaged index, or no room, or no permission
            try:
                self.flush()
                super().save_overload(sig, data)
            except Exception:
                pass


def cache_of(function):
    """The cache of a function; one that keeps nothing where no folder for it can be written."""
    try:
        return KernelCache(function)
    except (RuntimeError, OSError):
        return NullCache()
