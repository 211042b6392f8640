"""Everything that knows of other processes: communicator, slab FFT, halo rows, parallel HDF5."""
