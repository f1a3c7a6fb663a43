#!/usr/bin/env bash
# PCL 1.13.0 (Debian 12: pcl-tools 1.13.0+dfsg-3): pcl_converter and pcl_vtk2obj write the coordinates of a .obj with five digits. A ball of 2 mm at
# z = 1345.6 mm, as bones lie in the coordinates of a CT, becomes a stack of steps of 0.1 mm: of 49 heights of its vertices 21 are left, of
# 4514 vertices 4290, and 448 of 9024 triangles have no area. The volume is right to 1 %, so that it does not show. The same ball at
# 0 0 0 is right; in micrometers it would be the same at 13456. .ply and .stl by pcl_converter have all digits of single precision.
# No message, exit status 0.
# Seen on 2026-12-01: the lines below.
# Usage: findings/pcl_obj_digits.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

# Packages into the folder root, with an apt of its own that knows nothing of this machine's packages.
mkdir -p apt/lists/partial apt/cache/archives/partial root
: >apt/status
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | sort -u)
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror bookworm main" >apt/sources
bookworm=(apt-get -qq -o Dir::State="$PWD/apt" -o Dir::State::status="$PWD/apt/status" -o Dir::Cache="$PWD/apt/cache"
          -o Dir::Etc::sourcelist="$PWD/apt/sources" -o Dir::Etc::sourceparts=/dev/null -o APT::Sandbox::User=root
          -o Acquire::Check-Valid-Until=false -o Acquire::Languages=none -o APT::Install-Recommends=false)
"${bookworm[@]}" update
"${bookworm[@]}" install --download-only -y pcl-tools=1.13.0+dfsg-3 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >ball.py <<'P'
import math
import subprocess


def ball(center, radius=1, around=96, along=48):
    points = [(0, 0, radius)]
    for i in range(1, along):
        t = math.pi * i / along
        points += [(radius * math.sin(t) * math.cos(2 * math.pi * j / around), radius * math.sin(t) * math.sin(2 * math.pi * j / around),
                    radius * math.cos(t)) for j in range(around)]
    points.append((0, 0, -radius))
    last, triangles = len(points) - 1, []
    for j in range(around):
        k = (j + 1) % around
        triangles += [(0, 1 + j, 1 + k), (last, last - around + k, last - around + j)]
        for a in range(1, last - around, around):
            triangles += [(a + j, a + j + around, a + k), (a + k, a + j + around, a + k + around)]
    return [tuple(c + x for c, x in zip(center, p)) for p in points], triangles


def write_ply(points, triangles):
    with open("root/ball.ply", "w") as out:
        print("ply\nformat ascii 1.0\nelement vertex", len(points), file=out)
        print("property float x\nproperty float y\nproperty float z", file=out)
        print("element face %d\nproperty list uchar int vertex_indices\nend_header" % len(triangles), file=out)
        for p in points:
            print("%.9g %.9g %.9g" % p, file=out)
        for t in triangles:
            print(3, *t, file=out)


def run(*command):
    return subprocess.run(["chroot", "root", *command], check=True, capture_output=True)


def report(name, points, center):
    lines = [line.split() for line in open("root/ball.obj")]
    read = [tuple(map(float, line[1:4])) for line in lines if line[:1] == ["v"]]
    faces = [[int(i.split("/")[0]) - 1 for i in line[1:4]] for line in lines if line[:1] == ["f"]]
    six, flat = 0, 0
    for t in faces:
        a, b, c = ([read[i][k] - center[k] for k in range(3)] for i in t)
        cross = [(b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]), (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]),
                 (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])]
        six += sum(x * y for x, y in zip(a, cross))
        flat += math.hypot(*cross) < 1e-9
    print("%s: %d of %d vertices, %d heights, %d of %d triangles flat, volume %.3f mm3, moved by up to %.3f mm" % (
        name, len(set(read)), len(points), len({p[2] for p in read}), flat, len(faces), six / 6, max(math.dist(p, q) for p, q in zip(points, read))))


for center in ((0, 0, 0), (120.4, -215.3, 1345.6)):
    points, triangles = ball(center)
    write_ply(points, triangles)
    run("pcl_converter", "/ball.ply", "/ball.obj")
    report("pcl_converter, at z = %g" % center[2], points, center)
run("pcl_ply2vtk", "/ball.ply", "/ball.vtk")
run("pcl_vtk2obj", "/ball.vtk", "/ball.obj")
report("pcl_vtk2obj", points, center)
P
python3 ball.py | tee seen
diff seen - <<'E' || exit 1
pcl_converter, at z = 0: 4514 of 4514 vertices, 49 heights, 0 of 9024 triangles flat, volume 4.181 mm3, moved by up to 0.000 mm
pcl_converter, at z = 1345.6: 4290 of 4514 vertices, 21 heights, 448 of 9024 triangles flat, volume 4.220 mm3, moved by up to 0.049 mm
pcl_vtk2obj: 4290 of 4514 vertices, 21 heights, 448 of 9024 triangles flat, volume 4.220 mm3, moved by up to 0.049 mm
E
