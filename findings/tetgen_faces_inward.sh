#!/usr/bin/env bash
# TetGen 1.5.0 (Debian 12: tetgen 1.5.0-5): the triangles of a .face file are listed so that their normals point into the mesh, whichever way the
# facets of the .poly or .stl were listed; the same surface as "-g" writes it (.mesh of Medit) as well. The surface of a bone that was meshed for
# finite elements and goes on as STL or OBJ from there is therefore inside out: its signed volume is negative, and programs that take the side from
# the normals (not from a count of crossings) take the outside for bone.
# Seen on 2026-11-30: a unit cube with its facets outwards, and inwards: volume by .face -1 and -1, by .mesh -1 and -1.
# Usage: findings/tetgen_faces_inward.sh     needs python3 and root's apt; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
apt-get download -qq tetgen=1.5.0-5 libtet1.5=1.5.0-5 2>/dev/null
for package in ./*.deb; do dpkg -x "$package" root; done
LD_LIBRARY_PATH=$(dirname "$(find "$PWD/root" -name "libtet.so*" | head -1)")
export LD_LIBRARY_PATH

cube() {  # ORDER of the corners of each facet
    printf '8 3 0 0\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n6 0\n'
    for facet in '1 4 3 2' '5 6 7 8' '1 2 6 5' '2 3 7 6' '3 4 8 7' '4 1 5 8'; do
        read -ra corners <<<"$facet"
        [[ $1 == outwards ]] || corners=("${corners[3]}" "${corners[2]}" "${corners[1]}" "${corners[0]}")
        printf '1\n4 %s\n' "${corners[*]}"
    done
    printf '0\n0\n'
}
for order in outwards inwards; do
    cube $order >cube.poly
    root/usr/bin/tetgen -pgQ cube.poly >/dev/null
    python3 - $order <<'P'
import sys


def volume(points, triangles):
    total = 0
    for a, b, c in ([points[k - 1] for k in t] for t in triangles):
        total += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    return total


def rows(text):
    return [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]


nodes = [[float(x) for x in row[1:4]] for row in rows(open("cube.1.node").read())[1:]]
faces = [[int(k) for k in row[1:4]] for row in rows(open("cube.1.face").read())[1:]]
mesh = [line.split() for line in open("cube.1.mesh") if line.strip() and not line.startswith("#")]
at = mesh.index(["Triangles"])
medit = [[int(k) for k in row[:3]] for row in mesh[at + 2:at + 2 + int(mesh[at + 1][0])]]
print(f"facets {sys.argv[1]}: volume by .face {volume(nodes, faces):.6g}, by .mesh {volume(nodes, medit):.6g}")
P
done | tee seen
diff seen - <<'E2' || exit 1
facets outwards: volume by .face -1, by .mesh -1
facets inwards: volume by .face -1, by .mesh -1
E2
