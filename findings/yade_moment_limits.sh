#!/usr/bin/env bash
# YADE 2025.2.0 (Debian 13: yade 2025.2.0-1+b1; 2026.1 likewise, 2023.02a of Debian 12 does not): a cohesive bond has limits on its moments
# that nobody sets. Ip2_CohFrictMat_CohFrictMat_CohFrictPhys fills rollingAdhesion with a quarter of normalAdhesion times the smaller radius
# and twistingAdhesion with half of shearAdhesion times it, although the material's etaRoll and etaTwist have their default, -1, and
# Law2_ScGeom6D_CohFrictPhys_CohesionMoment breaks the bond where its bending moment reaches the first. 2023.02a knows no such limit:
# the bond of the same script is whole at twice that moment, and a bonded bone of the same input bears twice the stress there.
# Seen on 2026-11-27: "normal 402 N, rolling 0.161 N m (0.25 of normal times radius), ...", "bent: broken at 0.161 N m".
# Usage: findings/yade_moment_limits.sh     needs root's apt and chroot and 500 MB of Debian 13's packages; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages of Debian 13 into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror trixie main" >apt/sources
trixie=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
        -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
        -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${trixie[@]}" update
"${trixie[@]}" install --download-only -y yade=2025.2.0-1+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/bend.py <<'P'
import math
import os
import sys

from yade import *

stiffness, radius = math.pi / 2 * 1e10, 1.6e-3
O.materials.append(CohFrictMat(young=stiffness, poisson=0.4, density=1900, frictionAngle=0.5, normalCohesion=math.pi * 5e7,
                               shearCohesion=math.pi * 4e7, momentRotationLaw=True, alphaKr=0.6, alphaKtw=0.5, isCohesive=True,
                               fragile=True))
O.bodies.append([utils.sphere((0, 0, 0), radius), utils.sphere((0, 0, 2 * radius), radius)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(aabbEnlargeFactor=1.0005)]),
             InteractionLoop([Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=1.0005)],
                             [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)],
                             [Law2_ScGeom6D_CohFrictPhys_CohesionMoment()]),
             NewtonIntegrator(damping=0, gravity=(0, 0, 0))]
O.dt = 1e-9
for body in O.bodies:
    body.state.blockedDOFs = "xyzXYZ"
O.step()
bond = O.interactions[0, 1].phys
limits = bond.dict()
print("etaRoll %g etaTwist %g" % (O.materials[0].etaRoll, O.materials[0].etaTwist))
print("normal %.0f N, rolling %.3f N m (%.2f of normal times radius), twisting %.3f N m (%.2f of shear times radius)" % (
    bond.normalAdhesion, limits["rollingAdhesion"], limits["rollingAdhesion"] / bond.normalAdhesion / radius,
    limits["twistingAdhesion"], limits["twistingAdhesion"] / bond.shearAdhesion / radius))
O.bodies[0].state.angVel, O.bodies[1].state.angVel = (-300, 0, 0), (300, 0, 0)
moment = 0
for step in range(40000):
    O.step()
    bond = O.interactions[0, 1].phys if O.interactions.has(0, 1) else None
    if bond is None or bond.cohesionBroken:
        print("bent: broken at %.3f N m" % moment)
        break
    moment = bond.moment_bending.norm()
else:
    print("bent: whole at %.3f N m" % moment)
sys.stdout.flush()
os._exit(0)
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp UCX_LOG_LEVEL=fatal \
    /usr/bin/python3 /usr/bin/yade -n -x -j1 /bend.py 2>messages | grep -E "^(etaRoll|normal|bent)" | tee seen
diff seen - <<'E' || exit 1
etaRoll -1 etaTwist -1
normal 402 N, rolling 0.161 N m (0.25 of normal times radius), twisting 0.257 N m (0.50 of shear times radius)
bent: broken at 0.161 N m
E
