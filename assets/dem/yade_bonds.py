"""Bonds of a file of vdb_pack in YADE 2023.02a to 2026.1, each with its own stiffness and strength.

    import sys; sys.path.append("assets/dem")  # of the repository
    from yade import ymport
    from yade_bonds import bond_engines, load_bonds, load_materials

    load_materials("materials.csv")
    O.bodies.append(ymport.textExt("pack.txt", "x_y_z_r_matId"))
    O.engines = bond_engines()
    bonds = load_bonds("bonds.csv")
    O.dt = 0.3 * PWaveTimeStep()

The files are those of `vdb_pack pack ... --out-unit m -o yade:pack.txt -o materials:materials.csv -o bonds:bonds.csv`;
with `--bond-strength` bonds break. Contacts that appear later have the stiffness of the material, and friction.
"""

import csv

from yade import *
from yade.utils import *


def bonded_material(**properties):
    """A material whose contacts may be bonded. properties: young, density, frictionAngle, poisson, ..."""
    return CohFrictMat(
        normalCohesion=1,  # until bonds get their own
        shearCohesion=1,
        momentRotationLaw=True,
        isCohesive=True,
        fragile=True,
        **{"poisson": 0.3, **properties},
    )


def load_materials(path, young=1e9, **properties):
    """Appends a bonded_material for each row of a file of `materials:`, with its density and modulus_MPa.

    young: Pa, of rows without a modulus. properties: of all of them: frictionAngle, poisson, ...
    """
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            modulus = 1e6 * float(row.get("modulus_MPa") or 0)
            O.materials.append(bonded_material(young=modulus or young, density=float(row["density_kg_m3"]) or 1000,
                                               **properties))


def bond_engines(damping=0.3):
    """Engines for bonds: forces, collisions, contacts, and motion with so much damping, without gravity."""
    return [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop(
            # Else YADE counts ways across a gap as shorter, by the sum of the radii divided by the distance.
            [Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=False)],
            [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True, label="makesBonds")],
            [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(always_use_moment_law=False)],
        ),
        NewtonIntegrator(damping=damping, gravity=(0, 0, 0)),
    ]


def rows_of(path, first, ids):
    """The two bodies of each row of a file of bonds, and the row."""
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            yield [ids[int(row[e])] if ids else first + int(row[e]) for e in "ij"], row


def check_bonds(path, first, ids):
    """Refuses bonds of bodies that are not there, of another pack, or in other units."""
    stiffest = hardest = 0
    for ends, row in rows_of(path, first, ids):
        if lost := [end for end in ends if end >= len(O.bodies) or O.bodies[end] is None]:
            raise ValueError(f"{path}: bonds body {lost[0]}, and the scene has {len(O.bodies)} bodies; append the pack to O.bodies "
                             "before load_bonds(), and set `first` where others stand before its spheres")
        a, b = (O.bodies[end] for end in ends)
        apart = (b.state.pos - a.state.pos).norm()
        if not O.periodic and not 0.98 < apart / float(row.get("length") or apart) < 1.02:
            raise ValueError(f"{path}: a bond of {row['length']} joins spheres {apart:g} apart; write pack and bonds in one run, "
                             "with --out-unit m")
        stiffest = max(stiffest, float(row.get("modulus") or 0))
        hardest = max(hardest, a.material.young, b.material.young)
    if 0 < stiffest < 1e-4 * hardest:
        raise ValueError(f"{path}: bonds have moduli up to {stiffest:g}, in MPa, and materials up to {hardest:g}, in Pa; "
                         "write pack and bonds with --out-unit m")


def load_bonds(path, first=0, ids=None):
    """Bonds bodies by the rows of `path`; engines of bond_engines() must be there.

    first: body of the sphere whose id is 0. ids: instead, the body of each id (a dictionary).
    Returns the pairs of bodies, in the order of the rows. Bonds carry no force at first, whatever the gap.
    """
    makers = [p for e in O.engines if isinstance(e, InteractionLoop) for p in e.physDispatcher.functors
              if isinstance(p, Ip2_CohFrictMat_CohFrictMat_CohFrictPhys)]
    if not makers:
        raise RuntimeError("set O.engines = bond_engines() before load_bonds(), which takes their kind of bond")
    maker = makers[0]
    check_bonds(path, first, ids)
    maker.setCohesionNow = True
    made = []
    for ends, row in rows_of(path, first, ids):
        one = createInteraction(*ends)
        phys = one.phys
        phys.kn, phys.ks, phys.kr, phys.ktw = (float(row[k]) for k in ("k_n", "k_t", "k_bending", "k_torsion"))
        phys.unp = one.geom.penetrationDepth
        # A strength of 0: the bond does not break.
        phys.normalAdhesion, phys.shearAdhesion = (float(row[s]) or 1e300 for s in ("tensile", "shear"))
        phys.fragile = phys.momentRotationLaw = True
        if hasattr(phys, "rollingAdhesion"):  # later versions also break bonds by their moments
            phys.rollingAdhesion = phys.twistingAdhesion = 1e300
        made.append(tuple(ends))
    maker.setCohesionNow = False  # contacts of later have friction only
    return made


def whole_bonds(pairs):
    """Whether each of the bonds that load_bonds() returned is whole."""
    ones = [O.interactions[i, j] if O.interactions.has(i, j) else None for i, j in pairs]
    return [one is not None and one.isReal and not one.phys.cohesionBroken for one in ones]
