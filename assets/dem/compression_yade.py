"""Uniaxial compression of a bonded pack between two grips, in SI units, for YADE 2023.02a to 2026.1.

`compress` writes setup.json, the settings for this pack and these materials. To run it alone:

    yade -n -x -j2 compression_yade.py setup.json pack.txt curve.csv

A bond is a CohFrictPhys with moments: it resists tension, shear, bending and torsion until its normal
or shear force exceeds its strength; then only friction remains.
"""

import json
import math
import sys
import time

from yade import ymport

with open(sys.argv[1]) as file:
    setup = json.load(file)

# matId of the pack is the region and so the place in this list: 0 cortical, 1 trabecular.
# YADE's stiffness is young * radius along and poisson times that across, a strength is cohesion
# times radius squared: with bars of the spheres' cross-section pi r^2 and length 2 r, both grow by
# pi / 2 and pi. Bending and torsion are those of the same bar.
shear_ratio = 1 / (2 * (1 + setup["poisson"]))
for material in (setup["cortical"], setup["trabecular"]):
    O.materials.append(
        CohFrictMat(
            young=math.pi / 2 * material["young"],
            poisson=shear_ratio,
            density=setup["density"],
            frictionAngle=math.atan(setup["friction"]),
            normalCohesion=math.pi * material["tensile_strength"],
            shearCohesion=math.pi * material["shear_strength"],
            momentRotationLaw=True,
            alphaKr=0.25 / shear_ratio,
            alphaKtw=0.5,
            isCohesive=True,
            fragile=True,
        )
    )

O.bodies.append(ymport.textExt(sys.argv[2]))
kind = [body.material.id for body in O.bodies]
heights = [body.state.pos[2] for body in O.bodies]
if set(kind) - {0, 1}:
    raise SystemExit(f"{sys.argv[2]}: matId is {max(kind)}, expected 0 or 1; pack with --shell")

# The grips: spheres centered within a layer at either end are held and moved towards each other,
# each at half the rate, so that the middle rests and the waves meet there.
bottom = [i for i, z in enumerate(heights) if z < setup["z_bottom"]]
top = [i for i, z in enumerate(heights) if z > setup["z_top"]]
for ids, speed in ((bottom, setup["speed"]), (top, -setup["speed"])):
    for i in ids:
        O.bodies[i].state.blockedDOFs = "xyzXYZ"
        O.bodies[i].state.vel = (0, 0, speed)

# Exactly touching spheres would get no bond at a factor of 1, for a gap of a rounding error.
reach = 1 + setup["bond_gap"] / 2
bounds = Bo1_Sphere_Aabb(aabbEnlargeFactor=reach)
geometry = Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=reach)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([bounds]),
    InteractionLoop(
        [geometry],
        [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)],
        [Law2_ScGeom6D_CohFrictPhys_CohesionMoment()],
    ),
    NewtonIntegrator(damping=setup["damping"], gravity=(0, 0, 0)),
]
O.dt = setup["dt"]

O.step()  # the bonds are made here; later contacts begin at touching and have friction only
for bond in O.interactions:
    if hasattr(bond.phys, "rollingAdhesion"):  # later versions also break bonds by their moments
        bond.phys.rollingAdhesion = bond.phys.twistingAdhesion = 1e300
bounds.aabbEnlargeFactor = 1
geometry.interactionDetectionFactor = 1


def bonds_and_shares():
    """Whole bonds by kind (cc, ct, tt), and the force that cortical and trabecular spheres carry.

    The share of a material is the sum of z-force times z-branch over its halves of contacts, by the
    gauge length; both add up to the force on the grips in equilibrium.
    """
    whole = [0, 0, 0]
    share = [0.0, 0.0]
    for contact in O.interactions:
        a, b = kind[contact.id1], kind[contact.id2]
        physics = contact.phys
        if not physics.cohesionBroken:
            whole[a + b] += 1
        branch = O.bodies[contact.id2].state.pos[2] - O.bodies[contact.id1].state.pos[2]
        half = (physics.normalForce[2] + physics.shearForce[2]) * branch / (2 * setup["gauge"])
        share[a] += half
        share[b] += half
    return whole, share


interval = setup["steps"] // setup["records"]
samples = 20 if interval >= 20 else 1  # waves run through the specimen: a record is a mean
started = time.time()
with open(sys.argv[3], "w") as curve:
    curve.write(
        "strain,closed_m,top_N,bottom_N,stress_Pa,cortical_N,trabecular_N,"
        "bonds_cc,bonds_ct,bonds_tt,kinetic_J\n"
    )
    whole, _ = bonds_and_shares()
    curve.write("0,0,0,0,0,0,0,%d,%d,%d,0\n" % tuple(whole))
    print("bonds: %d cortical, %d mixed, %d trabecular" % tuple(whole), flush=True)
    while O.iter < setup["steps"]:
        pushed_top = pushed_bottom = closed = 0.0
        for _ in range(samples):
            O.run(interval // samples, True)
            pushed_top += sumForces(top, (0, 0, 1)) / samples
            pushed_bottom -= sumForces(bottom, (0, 0, 1)) / samples
            closed += 2 * setup["speed"] * O.time / samples
        whole, share = bonds_and_shares()
        strain = closed / setup["gauge"]
        stress = (pushed_top + pushed_bottom) / 2 / setup["area"]
        curve.write(
            "%.8g,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g,%d,%d,%d,%.8g\n"
            % (strain, closed, pushed_top, pushed_bottom, stress, *share, *whole, kineticEnergy())
        )
        curve.flush()
        print(
            "step %d, %.0f s: strain %.4f, %.0f N, %d bonds"
            % (O.iter, time.time() - started, strain, pushed_top, sum(whole)),
            flush=True,
        )
