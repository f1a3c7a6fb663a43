"""Makes a periodic pack with pack.randomPeriPack and writes x, y, z, r with the lengths of its cell.

    yade -n -x -j1 yade_periodic.py LOW HIGH SIDE OUT.txt

Radii are uniform from LOW to HIGH. A cubic cell of SIDE is filled with as many spheres as find room at
random, about a quarter of it, and is then compressed.
"""
import sys

from yade import pack

low, high, side, path = float(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
mean = (low + high) / 2
spheres = pack.randomPeriPack(
    radius=mean,
    initSize=Vector3(side, side, side),
    rRelFuzz=(high - mean) / mean,
    noPrint=True,
    seed=1,
)

# Not export.text: it rounds coordinates to six digits, which causes overlaps.
with open(path, "w", encoding="ascii") as file:
    file.write("#format x_y_z_r\n")
    file.write("##PERIODIC:: " + " ".join(f"{length:.17g}" for length in spheres.cellSize) + "\n")
    for center, radius in spheres:
        file.write("\t".join(f"{value:.17g}" for value in (*center, radius)) + "\n")
