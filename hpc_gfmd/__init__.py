"""Elastic contact of rough surfaces, by Green's function molecular dynamics.

It runs on a laptop or, with its fields split into slabs, on a cluster.

    import hpc_gfmd
    surface = hpc_gfmd.read_surface("scan.x3p")             # or make_surface(...), or a NumPy array
    solution = hpc_gfmd.solve(surface, "20 MPa", "50 GPa")  # a list of loads gives Solutions
    solution.plot()
    solution.save("contact.h5")
    solutions = hpc_gfmd.load("contact.h5")                 # the same from a result file
    hpc_gfmd.run("scene.toml")                              # as the command line does

`reference` has contact areas and mean gaps of self-affine surfaces with their uncertainties. The
names are listed in __init__.pyi. Importing this package neither starts MPI nor compiles anything;
its parts are imported when they are first used.
"""

import lazy_loader

__version__ = "1.2.0.dev0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
