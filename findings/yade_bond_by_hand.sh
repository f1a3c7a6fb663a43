#!/usr/bin/env bash
# YADE 2025.2.0 (Debian 13: yade 2025.2.0-1+b1; 2026.1 likewise, 2023.02a of Debian 12 not): a script cannot bond two spheres by writing to
# their interaction. CohFrictPhys.cohesionBroken has no setter any more ("object has no setter"), while normalAdhesion and all
# stiffnesses still have one, and giving an interaction adhesion does not make it whole: cohesionBroken stays True, and the law lets
# it carry no tension. 2023.02a takes `cohesionBroken = False`. What works in all of them is to create the interaction while
# Ip2_CohFrictMat_CohFrictMat_CohFrictPhys has setCohesionNow, with any cohesion in the material, and to write stiffnesses and
# adhesions of one's own to it then.
# Seen on 2026-11-28: "assigned: has no setter", "adhesion alone: broken", "created with setCohesionNow: whole, adhesion 5".
# Usage: findings/yade_bond_by_hand.sh     needs root's apt and chroot and 500 MB of Debian 13's packages; exits with 1 if that changes.
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

cat >root/bond.py <<'P'
import os
import sys

from yade import *

O.materials.append(CohFrictMat(isCohesive=True, momentRotationLaw=True, normalCohesion=1, shearCohesion=1))
O.bodies.append([utils.sphere((0, 0, 2 * k), 1) for k in range(3)])
makes = Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
             InteractionLoop([Ig2_Sphere_Sphere_ScGeom6D()], [makes], [Law2_ScGeom6D_CohFrictPhys_CohesionMoment()])]
plain = createInteraction(0, 1).phys
try:
    plain.cohesionBroken = False
    print("assigned: taken")
except AttributeError as error:
    print("assigned:", "has no setter" if "has no setter" in str(error) else error)
plain.normalAdhesion = plain.shearAdhesion = 5
print("adhesion alone:", "broken" if plain.cohesionBroken else "whole")
makes.setCohesionNow = True
bond = createInteraction(1, 2).phys
bond.normalAdhesion = 5
print("created with setCohesionNow: %s, adhesion %g" % ("broken" if bond.cohesionBroken else "whole", bond.normalAdhesion))
sys.stdout.flush()
os._exit(0)
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp UCX_LOG_LEVEL=fatal \
    /usr/bin/python3 /usr/bin/yade -n -x -j1 /bond.py 2>messages | grep -E "^(assigned|adhesion|created)" | tee seen
diff seen - <<'E' || exit 1
assigned: has no setter
adhesion alone: broken
created with setCohesionNow: whole, adhesion 5
E
