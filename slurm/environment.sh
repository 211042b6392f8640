# Sourced by the job scripts: what differs from one cluster to the next. An example, to be edited once.

# ---- software: the same MPI with which scripts/setup built mpi4py and h5py ------------------------------------------
# module purge
# module load gcc openmpi hdf5/1.14-mpi fftw
root=${HPC_GFMD_ROOT:-$SLURM_SUBMIT_DIR}         # sbatch runs a copy of the script: its own path says nothing
export PATH=$root/.venv/bin:$PATH
export PYTHONNOUSERSITE=1
unset PYTHONHOME

# ---- ranks and threads: one rank per core, no hidden threads ----------------------------------------------------------
export OMP_NUM_THREADS=1                         # threads of a rank are asked for with machine.threads, not here
export SRUN_CPUS_PER_TASK=${SLURM_CPUS_PER_TASK:-1}  # srun does not take it over from sbatch since Slurm 22.05
export LAUNCHER=${LAUNCHER:-srun}                # or mpirun; see launch.sh

# ---- caches: a folder that all nodes see; kept from job to job ---------------------------------------------------------
# One rank compiles, the others read: on a node's own disk every node would compile for itself. Kernels are kept per processor
# type, so a partition of mixed nodes is no problem. For a cache of this job alone append /$SLURM_JOB_ID.
export HPC_GFMD_CACHE=${HPC_GFMD_CACHE:-$root/build/cache}            # FFTW's wisdom
export NUMBA_CACHE_DIR=${NUMBA_CACHE_DIR:-$HPC_GFMD_CACHE/numba}      # compiled kernels
mkdir -p "$HPC_GFMD_CACHE" "$NUMBA_CACHE_DIR"

# ---- communication -------------------------------------------------------------------------------------------------------
# export OMPI_MCA_pml=ucx UCX_TLS=rc,sm,self     # InfiniBand: fail rather than fall back to TCP
# export OMPI_MCA_btl=^openib                    # Open MPI 4 on such machines: silence its old driver
# export UCX_LOG_LEVEL=error
export OMPI_MCA_orte_execute_quiet=1             # no page of mpirun's own when a run ends with exit code 3

# ---- files: stripe large outputs over several servers; counts only for files created later ----------------------------
# command -v lfs >/dev/null && lfs setstripe -c 8 -S 16M results/
