#!/usr/bin/env bash
# mpich_alone.sh COMMAND...: run a command as if MPICH were the only MPI of this Debian. In a separate mount namespace, which other
# processes do not see, its programs are named mpirun, mpicc and h5pcc, and the library of Open MPI is empty. Needs root.
exec unshare --mount --propagation private bash -c '
set -e
alternatives=$(mktemp -d)
cp -a /etc/alternatives/. "$alternatives"
for link in "$alternatives"/*; do
    [ -L "$link" ] || continue  # such as a README
    target=$(readlink "$link")
    case $target in
        *.openmpi) if [ -e "${target%.openmpi}.mpich" ]; then ln -sfn "${target%.openmpi}.mpich" "$link"; else rm "$link"; fi ;;
    esac
done
mount --bind "$alternatives" /etc/alternatives
for library in /usr/lib/*/libmpi.so.[0-9]*; do mount --bind /dev/null "$(readlink -f "$library")"; done
for folder in /usr/lib/*/hdf5/openmpi; do mount -t tmpfs tmpfs "$folder"; done
exec "$@"' - "$@"
