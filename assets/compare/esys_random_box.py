"""ESyS-Particle's RandomBoxPacker fills a cube: esys_random_box.py SIDE LOW HIGH FILE

Writes `x y z r` lines of spheres with radii from LOW to HIGH, as they fit, in a cube about the
origin. Needs Debian's esys-particle, and its Python.
"""
import sys

from esys.lsm.geometry import RandomBoxPacker
from esys.lsm.util import BoundingBox, Vec3

half, low, high = float(sys.argv[1]) / 2, float(sys.argv[2]), float(sys.argv[3])
packer = RandomBoxPacker(
    minRadius=low,
    maxRadius=high,
    cubicPackRadius=2.2 * high,
    maxInsertFails=5000,
    bBox=BoundingBox(Vec3(-half, -half, -half), Vec3(half, half, half)),
    circDimList=[False, False, False],
    tolerance=1e-5,
)
packer.generate()
with open(sys.argv[4], "w", encoding="ascii") as file:
    for sphere in packer.getSimpleSphereCollection():
        center = sphere.getPosn()
        file.write("%.17g %.17g %.17g %.17g\n" % (center[0], center[1], center[2],
                                                  sphere.getRadius()))
