"""What an HDF5 file itself holds: a link, a virtual or an external dataset in it could name any other file of the machine."""

_HOPS = 16  # soft links on the way to an object


def item(group, name, hops=_HOPS):
    """The group or dataset `name`, or None if there is none. Raises ValueError if it, or its numbers, lie in another file."""
    import h5py

    here = group.file if name.startswith("/") else group
    for part in filter(None, name.split("/")):
        link = here.get(part, getlink=True) if isinstance(here, h5py.Group) else None
        if link is None:
            return None
        if isinstance(link, h5py.ExternalLink):
            raise ValueError(f"{name} is a link to another file")
        if isinstance(link, h5py.SoftLink) and hops == 0:
            raise ValueError(f"{name} is a link to a link to a link")
        here = item(here, link.path, hops - 1) if isinstance(link, h5py.SoftLink) else here[part]
    if isinstance(here, h5py.Dataset) and (here.is_virtual or here.external):
        raise ValueError(f"the numbers of {name} lie in another file")
    return here


def items(group):
    """(name, object) of everything directly in a group, as `item`."""
    return [(name, item(group, name)) for name in group]
