#!/usr/bin/env bash
# meshio 5.3.5 (Debian 13: python3-meshio 7.0.0-really-5.3.5-6+deb13u1): an OBJ whose normals are not as many as its points cannot be
# read, though each corner of a face names its own normal ("f 1//1 2//1 3//1") and one normal for a flat side is common. meshio takes
# the normals for values of the points and raises ValueError. With as many normals as points it reads the file and gives normal number
# i to point number i, whatever the faces say: wrong where the faces name them in another order.
# Seen on 2026-11-27: "one normal: ValueError" and, for faces that give point 1 the normal 0 0 1, "normal of point 1: 1 0 0".
# Usage: findings/meshio_obj_shared_normal.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y "python3-meshio=7.0.0-really-5.3.5-6+deb13u1" base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >root/normals.py <<'P'
import meshio

points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
open("/tmp/one.obj", "w").write(points + "vn 0 0 1\nf 1//1 2//1 3//1\n")
open("/tmp/three.obj", "w").write(points + "vn 1 0 0\nvn 0 1 0\nvn 0 0 1\nf 1//3 2//1 3//2\n")
try:
    meshio.read("/tmp/one.obj")
    print("one normal: read")
except ValueError:
    print("one normal: ValueError")
print("normal of point 1:", *(f"{c:g}" for c in meshio.read("/tmp/three.obj").point_data["obj:vn"][0]))
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /normals.py | tee seen
diff seen - <<'E' || exit 1
one normal: ValueError
normal of point 1: 1 0 0
E
