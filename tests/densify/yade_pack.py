"""Makes yade_pack.txt: yade -n -x yade_pack.py FILE. A periodic pack that YADE compressed and cut
from its tiles, its spheres a little larger: overlaps of 2 % of the smaller radius."""
import sys
from yade import export, pack

box = pack.inAlignedBox((0, 0, 0), (10, 10, 10))
spheres = pack.randomDensePack(box, radius=0.6, rRelFuzz=0.3, spheresInCell=300, seed=1,
                               returnSpherePack=True)
grown = pack.SpherePack([(center, 1.0035 * radius) for center, radius in spheres])
grown.toSimulation()
export.text(sys.argv[1])
