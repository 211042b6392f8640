# What the package offers: lazy_loader reads the names here, type checkers the types.
from .output.interface_law import InterfaceLaw as InterfaceLaw
from .output.law_files import read_law as read_law
from .output.law_files import write_law as write_law
from .parallel.guard import on_rank_0 as on_rank_0
from .parallel.world import world as world
from .runs.ensemble import Ensemble as Ensemble
from .runs.interface_law import interface_law as interface_law
from .runs.many import solve_many as solve_many
from .runs.plot import plot as plot
from .runs.prepared import PreparedSurface as PreparedSurface
from .runs.simulation import run as run
from .runs.slip import slip as slip
from .runs.solution import Solution as Solution
from .runs.solutions import Interrupted as Interrupted
from .runs.solutions import Solutions as Solutions
from .runs.solutions import load as load
from .runs.solve import solve as solve
from .runs.spectra import spectrum_of as spectrum_of
from .runs.surfaces import combine_surfaces as combine_surfaces
from .runs.surfaces import make_surface as make_surface
from .runs.surfaces import prepare_surface as prepare_surface
from .runs.surfaces import read_surface as read_surface
from .surface.spectra import Spectrum as Spectrum
from .theory import reference as reference
from .util.errors import GfmdError as GfmdError
from .util.errors import NotConverged as NotConverged
from .util.errors import SceneError as SceneError
from .util.errors import SurfaceWarning as SurfaceWarning

__version__: str
