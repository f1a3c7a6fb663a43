#!/usr/bin/env bash
# YADE 2025.2.0 (Debian 13: yade 2025.2.0-1+b1; 2023.02a of Debian 12 likewise): ScGeom and ScGeom6D scale the way of a shear by the
# sum of the radii divided by the distance of the centers, as long as Ig2_Sphere_Sphere_ScGeom6D has avoidGranularRatcheting, which it has by
# default. Two bonded spheres with a gap between them are therefore softer across than the ks that their interaction shows (by 2.8 % at a
# gap of a fifteenth of the smaller radius), and overlapping ones stiffer; along the line of the centers kn is exact. With
# avoidGranularRatcheting=False the force is ks times the way, whatever the gap.
# Seen on 2026-11-28: "distance 1.80: 0.9722 of ks times the way, radii by distance 0.9722, not avoiding ratcheting 1.0000".
# Usage: findings/yade_shear_across_gap.sh   needs root's apt and chroot and 500 MB of Debian 13's packages; exits with 1 if that changes.
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

cat >root/shear.py <<'P'
import os
import sys

from yade import *


def share(distance, avoids):
    O.reset()
    O.materials.append(CohFrictMat(isCohesive=True, momentRotationLaw=True, normalCohesion=1e12, shearCohesion=1e12))
    O.bodies.append([utils.sphere((0, 0, 0), 1), utils.sphere((0, 0, distance), 0.75)])
    ig2 = Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=avoids)
    O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
                 InteractionLoop([ig2], [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)],
                                 [Law2_ScGeom6D_CohFrictPhys_CohesionMoment()]), NewtonIntegrator()]
    phys = createInteraction(0, 1).phys
    phys.kn, phys.ks, phys.kr, phys.ktw, phys.unp = 1000, 400, 0, 0, O.interactions[0, 1].geom.penetrationDepth
    phys.normalAdhesion = phys.shearAdhesion = 1e12
    for body in O.bodies:
        body.state.blockedDOFs = "xyzXYZ"
    O.dt = 1e-6
    O.step()
    O.bodies[1].state.vel = (1, 0, 0)  # for one step: 1e-6
    O.step()
    O.bodies[1].state.vel = (0, 0, 0)
    O.step()
    return -O.forces.f(1)[0] / (400 * 1e-6)


for distance in (1.75, 1.8, 1.7):
    print("distance %.2f: %.4f of ks times the way, radii by distance %.4f, not avoiding ratcheting %.4f"
          % (distance, share(distance, True), 1.75 / distance, share(distance, False)))
sys.stdout.flush()
os._exit(0)
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp UCX_LOG_LEVEL=fatal \
    /usr/bin/python3 /usr/bin/yade -n -x -j1 /shear.py 2>messages | grep -E "^distance" | tee seen
diff seen - <<'E' || exit 1
distance 1.75: 1.0000 of ks times the way, radii by distance 1.0000, not avoiding ratcheting 1.0000
distance 1.80: 0.9722 of ks times the way, radii by distance 0.9722, not avoiding ratcheting 1.0000
distance 1.70: 1.0294 of ks times the way, radii by distance 1.0294, not avoiding ratcheting 1.0000
E
