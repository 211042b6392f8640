# Packages of Spack (July 2026) have all that is named here, but for py-mpi4py-fft beside this one.
# SurfaceTopography (files of instruments) is not among them: pip adds it.
from spack_repo.builtin.build_systems.python import PythonPackage

from spack.package import *


class PyHpcGfmd(PythonPackage):
    """Elastic contact of rough surfaces, with certified errors, from a laptop to a supercomputer."""

    pypi = "hpc-gfmd/hpc_gfmd-1.0.0.tar.gz"

    license("BSD-3-Clause")

    # the checksum of the released archive: version("1.0.0", sha256="...")
    version("1.0.0")

    variant("mpi", default=True, description="Many ranks, FFTW and one result file written by all of them")

    depends_on("python@3.11:", type=("build", "run"))
    depends_on("py-setuptools@77:", type="build")

    with default_args(type="run"):
        depends_on("py-numpy@2.0.1:")
        depends_on("py-numba@0.61:")
        depends_on("py-scipy@1.13:")
        depends_on("py-pandas@2.2.2:")
        depends_on("py-pydantic@2.10:2")
        depends_on("py-matplotlib@3.9:")
        depends_on("py-tomli-w@1:")
        depends_on("py-tqdm@4.60:")
        depends_on("py-pint@0.24.4:")
        depends_on("py-lazy-loader@0.4:")
        depends_on("py-h5py@3.12.1: +mpi", when="+mpi")
        depends_on("py-h5py@3.12.1: ~mpi", when="~mpi")
        depends_on("py-mpi4py@4:", when="+mpi")
        depends_on("py-mpi4py-fft@2.0.6:", when="+mpi")

    skip_modules = ["hpc_gfmd.parallel"]
