"""Compression of a bonded pack between two grips, in SI units, for YADE 2023.02a to 2026.1.

`compress` writes setup.json, spheres.csv and bonds.csv. To run it alone, in their folder:

    yade -n -x -j2 compression_yade.py curve.csv

Each bond is a CohFrictPhys with the stiffnesses of its row of bonds.csv (yade_bonds.py, beside this script): it
resists tension, shear, bending and torsion until its normal or shear force exceeds its strength; then only
friction remains.
"""

import csv
import json
import math
import os
import sys
import time

sys.path.append(os.path.dirname(os.path.abspath(sys.argv[0])))
from yade_bonds import bond_engines, bonded_material, load_bonds, whole_bonds

with open("setup.json") as file:
    setup = json.load(file)


def table(name):
    with open(name, newline="") as rows:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(rows)]


spheres = table("spheres.csv")
O.materials.append(bonded_material(young=setup["young"], density=1000, frictionAngle=math.atan(setup["friction"])))
for row in spheres:
    O.bodies.append(sphere((row["x"], row["y"], row["z"]), row["radius"]))
    state = O.bodies[-1].state
    state.mass = row["mass"]
    state.inertia = (0.4 * row["mass"] * row["radius"] ** 2,) * 3
    if row["grip"]:
        state.blockedDOFs = "xyzXYZ"
        state.vel = (0, 0, -row["grip"] * setup["speed"])
bottom = [i for i, row in enumerate(spheres) if row["grip"] < 0]
top = [i for i, row in enumerate(spheres) if row["grip"] > 0]
O.engines = bond_engines()
O.dt = setup["dt"]
made = load_bonds("bonds.csv")


samples = min(20, setup["steps"] // setup["records"])  # waves run through the specimen: a record is a mean
started = time.time()
with open(sys.argv[1], "w") as curve:
    curve.write("strain,closed_m,top_N,bottom_N,stress_Pa,bonds,kinetic_J\n")
    curve.write("0,0,0,0,0,%d,0\n" % sum(whole_bonds(made)))
    for record in range(setup["records"]):
        pushed_top = pushed_bottom = closed = 0.0
        for sample in range(samples):
            until = setup["steps"] * (record * samples + sample + 1) // (setup["records"] * samples)
            O.run(until - O.iter, True)
            pushed_top += sumForces(top, (0, 0, 1)) / samples
            pushed_bottom -= sumForces(bottom, (0, 0, 1)) / samples
            closed += 2 * setup["speed"] * O.time / samples
        left = sum(whole_bonds(made))
        strain = closed / setup["gauge"]
        stress = (pushed_top + pushed_bottom) / 2 / setup["area"]
        curve.write(
            "%.8g,%.8g,%.8g,%.8g,%.8g,%d,%.8g\n"
            % (strain, closed, pushed_top, pushed_bottom, stress, left, kineticEnergy())
        )
        curve.flush()
        print(
            "step %d, %.0f s: strain %.4f, %.0f N, %d bonds"
            % (O.iter, time.time() - started, strain, pushed_top, left),
            flush=True,
        )
with open("whole_yade.csv", "w") as file:
    file.write("whole\n" + "".join("%d\n" % state for state in whole_bonds(made)))
