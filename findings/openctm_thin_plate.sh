#!/usr/bin/env bash
# OpenCTM 1.0.3 (Debian 12: openctm-tools 1.0.3+dfsg1-2.1+b3): ctmconv moves the vertices of a mesh that it writes as .ctm to a grid whose step is about
# 1 % of the mesh's mean edge length, since it takes the method MG2 where none is named; neither its manual page nor its help names that
# default or the step. The long edges of flat parts so set the step for what is thin: a plate of 10 x 10 x 0.05 comes back 0.0825 thick and 9.98
# long, one of 0.02 has no thickness and no volume, and of two blocks 0.05 apart the gap is closed, so that two bones are one. No message, exit
# status 0, and as many triangles as before. "--method MG1" keeps every coordinate.
# Seen on 2026-11-30: "plate of 0.02: thickness 0, length 9.978, volume 0", "--method MG1: thickness 0.02, length 10, volume 2".
# Usage: findings/openctm_thin_plate.sh     needs python3 and root's apt; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
apt-get download -qq openctm-tools=1.0.3+dfsg1-2.1+b3 libopenctm1=1.0.3+dfsg1-2.1+b3 libtinyxml2.6.2v5 2>/dev/null
for package in ./*.deb; do dpkg -x "$package" root; done
lib=$(find "$PWD/root" -name "libopenctm.so.1*" -print -quit)
export LD_LIBRARY_PATH=${lib%/*}

cat >blocks.py <<'P'
"""write FILE.off X0 X1 Z [X0 X1 Z ...]: blocks of 10 along y; show FILE.off: what came back"""
import sys

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
SIDES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def write(name, sizes):
    points, faces = [], []
    for x0, x1, high in zip(sizes[::3], sizes[1::3], sizes[2::3]):
        for a, b, c, d in SIDES:
            faces += [[len(points) + k for k in (a, b, c)], [len(points) + k for k in (a, c, d)]]
        points += [((x0, x1)[x], 10 * y, high * z) for x, y, z in CORNERS]
    with open(name, "w") as file:
        print(f"OFF\n{len(points)} {len(faces)} 0", file=file)
        for point in points:
            print(*point, file=file)
        for face in faces:
            print(3, *face, file=file)


def show(name):
    words = open(name).read().split()[1:]
    n, m = int(words[0]), int(words[1])
    points = [tuple(map(float, words[3 + 3 * i:6 + 3 * i])) for i in range(n)]
    faces = [list(map(int, words[4 + 3 * n + 4 * i:7 + 3 * n + 4 * i])) for i in range(m)]
    volume = 0
    for a, b, c in ([points[k] for k in face] for face in faces):
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    xs, zs = sorted({p[0] for p in points}), [p[2] for p in points]
    gap = f"blocks end and begin at {' '.join(f'{x:.4g}' for x in xs[1:-1])}, " if n > 8 else ""
    print(f"{gap}thickness {max(zs) - min(zs):.3g}, length {xs[-1] - xs[0]:.4g}, volume {volume:.3g}, triangles {m}")


if sys.argv[1] == "write":
    write(sys.argv[2], [float(x) for x in sys.argv[3:]])
else:
    show(sys.argv[2])
P
through() {  # NAME OPTIONS: to .ctm and back
    root/usr/bin/ctmconv in.off mesh.ctm "${@:2}" >log
    root/usr/bin/ctmconv mesh.ctm out.off >>log
    printf '%s: ' "$1"
    python3 blocks.py show out.off
}
{
    for thickness in 0.5 0.1 0.05 0.02; do
        python3 blocks.py write in.off 0 10 $thickness
        through "plate of $thickness"
    done
    through 'plate of 0.02, --method MG1' --method MG1
    python3 blocks.py write in.off 0 10 10 10.05 20 10
    through 'two blocks'
    through 'two blocks, --method MG1' --method MG1
} | tee seen
diff seen - <<'E' || exit 1
plate of 0.5: thickness 0.501, length 10, volume 50.2, triangles 12
plate of 0.1: thickness 0.0826, length 9.982, volume 8.23, triangles 12
plate of 0.05: thickness 0.0825, length 9.98, volume 8.22, triangles 12
plate of 0.02: thickness 0, length 9.978, volume 0, triangles 12
plate of 0.02, --method MG1: thickness 0.02, length 10, volume 2, triangles 12
two blocks: blocks end and begin at 10, thickness 9.96, length 19.96, volume 1.98e+03, triangles 24
two blocks, --method MG1: blocks end and begin at 10 10.05, thickness 10, length 20, volume 1.99e+03, triangles 24
E
