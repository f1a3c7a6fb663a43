"""Dumps and figures of LAMMPS and LIGGGHTS."""

from client import require, require_close


def rows_of_dump(path):
    """The rows of the first frame of a text dump, by name of the column."""
    lines = path.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
    names = lines[at].split()[2:]
    rows = []
    for line in lines[at + 1:]:
        if line.startswith("ITEM"):
            break
        rows.append([float(c) for c in line.split()])
    return dict(zip(names, map(list, zip(*rows))))


def thermo_of(log):
    """Rows of numbers that begin with the steps 0 and 100."""
    rows = {}
    for line in log.splitlines():
        cells = line.split()
        if cells and cells[0] in ("0", "100") and len(cells) >= 3:
            try:
                rows[int(cells[0])] = [float(c) for c in cells]
            except ValueError:
                pass
    require(set(rows) == {0, 100}, f"no figures of steps 0 and 100:\n{log[-2000:]}")
    return rows


def check_atoms(table, found, digits):
    """Atoms sorted by id against the .csv; ids of files count from 1."""
    order = sorted(range(len(found["id"])), key=lambda i: found["id"][i])
    found = {name: [values[i] for i in order] for name, values in found.items()}
    require(len(found["id"]) == len(table["id"]),
            f"{len(found['id'])} atoms, not {len(table['id'])}")
    require_close("ids", found["id"], [i + 1 for i in table["id"]], 0)
    require_close("types", found["type"], [r + 1 for r in table["region"]], 0)
    off = max(require_close(axis, found[axis], table[axis], digits) for axis in "xyz")
    off_radius = require_close("radii", found["radius"], table["radius"], digits)
    return off, off_radius
