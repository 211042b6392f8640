"""Pictures of results and surfaces, without MPI; fields are read a few rows at a time."""
