#!/usr/bin/env bash
# ESyS-Particle 2.3.5 (Debian 13: esys-particle 2.3.5+dfsg2-11): a bond has its rest length where the spheres touch, not where they were
# bonded. RotBondPrms, NRotBondPrms and BrittleBeamPrms all take the sum of the radii for it (the tutorial has half a sentence on that, for
# beams), so the spheres of a bonded pack from a .geo file pull at each other across each gap and push at each overlap from the first
# step on. Of two spheres of radius 1 with a gap of 0.1 and normalK = 1000 (scaling=False) each feels a force of 100; with an overlap of
# 0.1, of -100. Breaking is counted from there too: with breakDistance=0.05 the bond is gone after the first step though nothing has moved.
# The beam, which the tutorial gives the mean of the radii for its radius and their sum for its length, takes its stiffness from the distance
# of the centers instead, E * pi * distance / 4: 1649 per unit for 1571 at a gap of 0.1. YADE and LAMMPS can measure from the first
# distance; the same bonded bone is at rest there and under a prestress here. (Step 0 saves no forces yet.)
# Seen on 2026-11-30: "rot gap 0.1: force 100", "nrot gap 0.1 breakDistance 0.05: bonds 1 0 0", "beam gap 0.1: force 164.934".
# Usage: findings/esys_bond_rest_length.sh     needs root's apt, unshare and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y esys-particle=2.3.5+dfsg2-11 openmpi-bin openssh-client base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/bond.py <<'P'
import sys

from esys.lsm import *
from esys.lsm.util import BoundingBox, Vec3

kind, gap, limit = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
open("/tmp/pair.geo", "w").write(f"""LSMGeometry 1.2
BoundingBox -10 -10 -10 10 10 10
PeriodicBoundaries 0 0 0
Dimension 3D
BeginParticles
Simple
2
{-1 - gap / 2:.6f} 0 0 1 0 1
{1 + gap / 2:.6f} 0 0 1 1 1
EndParticles
BeginConnect
1
0 1 1
EndConnect
""")
sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
sim.initNeighbourSearch(particleType="NRotSphere" if kind == "nrot" else "RotSphere", gridSpacing=5.0, verletDist=0.5)
sim.setNumTimeSteps(2)
sim.setTimeStepSize(1e-9)
sim.readGeometry("/tmp/pair.geo")
sim.setSpatialDomain(BoundingBox(Vec3(-20, -20, -20), Vec3(20, 20, 20)))
if kind == "rot":
    bond = RotBondPrms(name="bond", normalK=1000.0, shearK=1000.0, torsionK=1000.0, bendingK=1000.0, normalBrkForce=1e9,
                       shearBrkForce=1e9, torsionBrkForce=1e9, bendingBrkForce=1e9, tag=1, scaling=False)
elif kind == "nrot":
    bond = NRotBondPrms(name="bond", normalK=1000.0, breakDistance=limit, tag=1, scaling=False)
else:
    bond = BrittleBeamPrms(name="bond", youngsModulus=1000.0, poissonsRatio=0.25, cohesion=1e6, tanAngle=1.0, tag=1)
sim.createInteractionGroup(bond)
steps = dict(beginTimeStep=0, endTimeStep=2, timeStepIncr=1)
sim.createFieldSaver(InteractionScalarFieldSaverPrms(interactionName="bond", fieldName="count", fileName="/tmp/bonds", fileFormat="SUM", **steps))
sim.createFieldSaver(ParticleVectorFieldSaverPrms(fieldName="force", fileName="/tmp/force", fileFormat="RAW_WITH_ID", **steps))
sim.run()
P
mkdir -p root/proc root/sys root/dev
bond() {  # KIND GAP BREAKDISTANCE: the program sees this machine's /proc, /sys and /dev in a mount namespace of its own
    local lib=/usr/lib/x86_64-linux-gnu
    rm -f root/tmp/bonds* root/tmp/force*
    unshare -m bash -c 'for part in proc sys dev; do mount --rbind /$part root/$part; done; exec chroot root "$@"' mounts \
        /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread HOME=/tmp \
        /usr/bin/timeout 60 /usr/bin/mpirun.openmpi --allow-run-as-root --oversubscribe --mca btl self,sm --mca pml ob1 \
        --mca mpi_yield_when_idle 1 -np 2 /usr/bin/esysparticle /bond.py "$@" >messages 2>&1 || { cat messages; exit 1; }
    # Sphere 0 is on the left: a force to the right draws it towards the other.
    awk -v what="$1 gap $2" -v limit="$3" '
        FILENAME ~ /bonds/ { bonds = bonds " " $1 + 0 }
        FILENAME ~ /force.2/ && $1 == 0 { force = $(NF - 2) }
        END { print what (limit < 1 ? " breakDistance " limit ": bonds" bonds : ": force " force) }' root/tmp/bonds* root/tmp/force.2.dat
}
{
    bond rot 0 9
    bond rot 0.1 9
    bond rot -0.1 9
    bond nrot 0.1 9
    bond nrot 0.1 0.2
    bond nrot 0.1 0.05
    bond beam 0.1 9
    bond beam 0.2 9
    bond beam -0.1 9
} | tee seen
diff seen - <<'E' || exit 1
rot gap 0: force 0
rot gap 0.1: force 100
rot gap -0.1: force -100
nrot gap 0.1: force 100
nrot gap 0.1 breakDistance 0.2: bonds 1 1 1
nrot gap 0.1 breakDistance 0.05: bonds 1 0 0
beam gap 0.1: force 164.934
beam gap 0.2: force 345.575
beam gap -0.1: force -149.226
E
