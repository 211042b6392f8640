from spack_repo.builtin.build_systems.python import PythonPackage

from spack.package import *


class PyMpi4pyFft(PythonPackage):
    """Parallel fast Fourier transforms: FFTW and its redistributions for mpi4py."""

    pypi = "mpi4py-fft/mpi4py_fft-2.0.6.tar.gz"

    license("BSD-2-Clause")

    version("2.0.6", sha256="2d43aba64d1d6098896cb89942c686a7e8832f1ea6f1593e617d70f365407087")

    depends_on("c", type="build")
    depends_on("py-setuptools@42:", type="build")
    depends_on("py-cython@0.29.32:", type="build")
    depends_on("py-numpy", type=("build", "run"))
    depends_on("py-mpi4py", type=("build", "run"))
    depends_on("fftw@3: precision=float,double,long_double")

    def setup_build_environment(self, env: EnvironmentModifications) -> None:
        env.set("FFTW_ROOT", self.spec["fftw"].prefix)
