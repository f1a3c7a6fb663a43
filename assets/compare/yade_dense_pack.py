"""Fills a box or a closed GTS surface with pack.randomDensePack and writes x, y, z, r.

    yade -n -x -j1 yade_dense_pack.py DOMAIN LOW HIGH OUT.txt

DOMAIN is box:SIDE, about the origin, or a .gts file; radii are uniform from LOW to HIGH. Lengths in
the unit of DOMAIN. One periodic cell of 2000 spheres is compressed, repeated and cut.
"""
import sys

import gts
from yade import pack

domain, low, high, path = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
if domain.startswith("box:"):
    half = float(domain[4:]) / 2
    predicate = pack.inAlignedBox((-half, -half, -half), (half, half, half))
else:
    with open(domain, encoding="ascii") as file:
        predicate = pack.inGtsSurface(gts.read(file))

mean = (low + high) / 2
spheres = pack.randomDensePack(
    predicate,
    radius=mean,
    rRelFuzz=(high - mean) / mean,
    spheresInCell=2000,
    memoizeDb=None,
    returnSpherePack=True,
    seed=1,
)

# Not export.text: it rounds coordinates to six digits, which causes overlaps.
with open(path, "w", encoding="ascii") as file:
    file.write("#format x_y_z_r\n")
    for center, radius in spheres:
        file.write("\t".join(f"{value:.17g}" for value in (*center, radius)) + "\n")
