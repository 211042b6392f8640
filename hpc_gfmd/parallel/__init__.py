"""Everything that knows of other processes: communicator, slab transforms, halo rows, parallel
HDF5."""
