"""What an HDF5 file itself holds: a link, a virtual or an external dataset in it could name any other file of the machine."""

_HOPS = 16  # soft links on the way to an object


def item(group, name):
    """The group or dataset `name`, or None if there is none. Raises ValueError if it, or its numbers, lie in another file."""
    import h5py

    here, parts, hops = (group.file if name.startswith("/") else group), _parts(name), 0
    while parts:
        part = parts.pop(0)
        link = here.get(part, getlink=True) if isinstance(here, h5py.Group) else None
        if link is None:
            return None
        if isinstance(link, h5py.SoftLink):
            hops += 1
            if hops > _HOPS:
                raise ValueError(f"{name} is a link to a link to a link")
            parts = _parts(link.path) + parts
            here = group.file if link.path.startswith("/") else here
        elif isinstance(link, h5py.HardLink):
            here = here[part]
        else:
            raise ValueError(f"{name} is a link to another file")
    if isinstance(here, h5py.Dataset) and (here.is_virtual or here.external):
        raise ValueError(f"the numbers of {name} lie in another file")
    return here


def items(group):
    """(name, object) of everything directly in a group, as `item`."""
    return [(name, item(group, name)) for name in group]


def _parts(name):
    return [part for part in name.split("/") if part not in ("", ".")]
