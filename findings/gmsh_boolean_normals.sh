#!/usr/bin/env bash
# gmsh 4.13.1 (Debian 13: gmsh 4.13.1+ds1-6; 4.8.4 of Debian 12 likewise): the .stl of a solid made by BooleanDifference is closed, but not
# oriented: the faces that the tool has cut keep the direction that they have on the tool, into the solid. A box of 8 x 6 x 4 less a corner of
# 3 x 3 x 2 has a volume of 174; the signed volume of the triangles is 210, and along 16 edges two triangles run in the same direction.
# Meshing the volume as well (-3) changes nothing. A program that trusts normals or the order of corners takes the corner for bone.
# Seen on 2026-11-27: "box volume 192 edges in conflict 0", "notched volume 210 edges in conflict 16".
# Usage: findings/gmsh_boolean_normals.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y gmsh=4.13.1+ds1-6 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/box.geo <<'G'
SetFactory("OpenCASCADE");
Box(1) = {0,0,0, 8,6,4};
Mesh.CharacteristicLengthMax = 1;
G
sed '2a Box(2) = {0,0,0, 3,3,2};\nBooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }' root/box.geo >root/notched.geo
lib=/usr/lib/x86_64-linux-gnu
for part in "box 2" "notched 2" "notched 3"; do
    set -- $part
    chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread:$lib/hdf5/serial HOME=/tmp \
        /usr/bin/gmsh /$1.geo -$2 -format stl -o /$1.stl >messages 2>&1
    python3 - "$1" root/$1.stl <<'P'
import collections
import sys

corners = [tuple(float(x) for x in line.split()[1:]) for line in open(sys.argv[2]) if line.split()[0] == "vertex"]
triangles = [corners[i:i + 3] for i in range(0, len(corners), 3)]
volume = sum((a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
             for a, b, c in triangles)
edges = collections.Counter((t[k], t[(k + 1) % 3]) for t in triangles for k in range(3))
print(sys.argv[1], "volume %.4g edges in conflict" % volume, sum(n > 1 for n in edges.values()),
      "edges of one triangle", sum(edges[e] + edges[e[1], e[0]] == 1 for e in edges))
P
done | tee seen
diff seen - <<'E' || exit 1
box volume 192 edges in conflict 0 edges of one triangle 0
notched volume 210 edges in conflict 16 edges of one triangle 0
notched volume 210 edges in conflict 16 edges of one triangle 0
E
