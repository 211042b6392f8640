#!/usr/bin/env bash
# mpich_alone.sh COMMAND...: run a command where MPICH is the only MPI of this Debian, in a mount namespace of its own, so that
# nobody else sees it: its programs have the names mpirun, mpicc, h5pcc, and Open MPI's library is empty. As root.
exec unshare --mount --propagation private bash -c '
set -e
alternatives=$(mktemp -d)
cp -a /etc/alternatives/. "$alternatives"
for link in "$alternatives"/*; do
    [ -L "$link" ] || continue  # a README lies among them
    target=$(readlink "$link")
    case $target in
        *.openmpi) if [ -e "${target%.openmpi}.mpich" ]; then ln -sfn "${target%.openmpi}.mpich" "$link"; else rm "$link"; fi ;;
    esac
done
mount --bind "$alternatives" /etc/alternatives
for library in /usr/lib/*/libmpi.so.[0-9]*; do mount --bind /dev/null "$(readlink -f "$library")"; done
for folder in /usr/lib/*/hdf5/openmpi; do mount -t tmpfs tmpfs "$folder"; done
exec "$@"' - "$@"
