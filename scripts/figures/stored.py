"""Reads HDF5 files of the project: `with stored(FILE) as file:`. References to other files are refused, as in
lib/io/hdf5_reader.cpp."""
import contextlib

import h5py

from one_line import reading


def refuse_foreign(group, seen):
    """Refuses links other than hard links, datasets with values in another file, and groups with a second hard link
    (cycles and repeated expansion)."""
    address = h5py.h5o.get_info(group.id).addr
    if address in seen:
        raise ValueError(f"{group.name}: is a group with a second hard link, which is not followed")
    seen.add(address)
    for name in group:
        place = f"{group.name.rstrip('/')}/{name}"
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{place}: is a link, which is not followed")
        item = group[name]
        if isinstance(item, h5py.Dataset) and (item.external or item.is_virtual):
            raise ValueError(f"{place}: has its values in another file, which is not followed")
        if isinstance(item, h5py.Group):
            refuse_foreign(item, seen)


@contextlib.contextmanager
def stored(file):
    with reading(file), h5py.File(file) as content:
        refuse_foreign(content, set())
        yield content
