# Sourced by the job scripts: start a program on all ranks, and a run that survives the end of its job.

# launch COMMAND...: on all ranks of the job, or on $RANKS of them; returns its exit code. SIGUSR1 (the warning of
# `#SBATCH --signal=B:USR1@...`, which reaches this shell only) and SIGTERM are passed on to the ranks.
launch() {
    local ranks=${RANKS:-$SLURM_NTASKS} start pid code=0
    case ${LAUNCHER:-srun} in
        srun) start=(srun --mpi=pmix --ntasks="$ranks") ;;
        mpirun)
            start=(mpirun -n "$ranks")
            [ "${SLURM_CPUS_PER_TASK:-1}" = 1 ] || start+=(--map-by "slot:PE=$SLURM_CPUS_PER_TASK" --bind-to core) ;;
        *) echo "LAUNCHER: found $LAUNCHER, allowed: srun, mpirun" >&2; return 2 ;;
    esac
    "${start[@]}" "$@" &
    pid=$!
    trap 'echo "$(date +%T) signal USR1: the ranks are asked to stop"; kill -USR1 $pid' USR1
    trap 'kill -TERM $pid' TERM
    wait $pid || code=$?
    while kill -0 $pid 2>/dev/null; do  # a trapped signal ends wait, not the ranks
        code=0
        wait $pid || code=$?
    done
    trap '' USR1
    trap - TERM
    return $code
}

# run SCENE.toml [-o OUT.h5] [--set ...]: `hpc-gfmd run` on all ranks; returns the exit code of the launcher.
run() { launch python -m hpc_gfmd run "$@"; }

# solve SCENE OUT.h5 [--set ...]: whatever is missing of a result: nothing, the rest of an interrupted run, or all of it. The exit
# code is that of the run, 143 if it was stopped. Not all launchers tell (MPICH's mpirun returns 0), but the folder OUT.h5.partial
# does, which is gone from a finished run.
solve() {
    local scene=$1 out=$2 code=0
    shift 2
    if [ -e "$out" ] && [ ! -d "$out.partial" ]; then
        echo "$out is complete"
        return
    fi
    run "$scene" -o "$out" "$@" || code=$?
    case $code in
        0 | 3)
            if [ -d "$out.partial" ]; then
                echo "the launcher returned $code, but $out.partial is there: interrupted" >&2
                code=143
            elif [ ! -e "$out" ]; then
                echo "the launcher returned $code, but $out is not there" >&2
                code=1
            fi ;;
    esac
    return $code
}
