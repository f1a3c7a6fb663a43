#!/usr/bin/env bash
# CloudCompare 2.11.3 (Debian 12: cloudcompare 2.11.3-7.1), "-C2M_DIST", signed distances of points to a closed mesh: the sign is that of the one
# triangle found first among the nearest ones. Where the nearest point lies on a ridge whose faces meet at less than 90 degrees, the other
# triangle may be the one that decides, and points outside count as inside: along a ridge of 10 degrees half of those nearest to it, millimeters off
# the mesh, along one of 60 degrees still a quarter. At 100 degrees none is wrong. The magnitudes are right to seven digits, so that a histogram looks sound.
# So a check that centers of spheres lie within a bone passes spheres outside of it at thin crests and processes. No message.
# Seen on 2026-12-01: the lines below; 20,000 points at random around a prism whose ridge has that angle.
# Usage: findings/cloudcompare_sign_at_ridges.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y cloudcompare=2.11.3-7.1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp
for library in $(ls -d root/usr/lib/*/blas root/usr/lib/*/lapack root/usr/lib/cloudcompare root/usr/lib/*/cloudcompare 2>/dev/null); do
    echo "${library#root}"
done | paste -sd: >libraries

cat >ridges.py <<'P'
import math
import random
import subprocess


def toSegment(p, a, b):
    ab, ap = (b[0] - a[0], b[1] - a[1]), (p[0] - a[0], p[1] - a[1])
    t = min(1, max(0, (ap[0] * ab[0] + ap[1] * ab[1]) / (ab[0]**2 + ab[1]**2)))
    return math.hypot(ap[0] - t * ab[0], ap[1] - t * ab[1])


def distance(p, corners):
    """To the prism over a triangle, from z = 0 to 10; negative inside."""
    sides = [(corners[i], corners[(i + 1) % 3]) for i in range(3)]
    inside = all((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0 for a, b in sides)
    flat = (-1 if inside else 1) * min(toSegment(p, a, b) for a, b in sides)
    above = abs(p[2] - 5) - 5
    return math.hypot(flat, above) if flat > 0 and above > 0 else max(flat, above)


libraries = open("libraries").read().strip()
random.seed(1)
for angle in (10, 30, 60, 80, 100):
    half = 10 * math.tan(math.radians(angle / 2))
    corners = [(0, 0), (10, -half), (10, half)]
    with open("root/tmp/prism.obj", "w") as mesh:
        for z in (0, 10):
            mesh.writelines("v %.9f %.9f %d\n" % (x, y, z) for x, y in corners)
        faces = [(1, 3, 2), (4, 5, 6)]
        for i in range(3):
            j = (i + 1) % 3
            faces += [(i + 1, j + 1, j + 4), (i + 1, j + 4, i + 4)]
        mesh.writelines("f %d %d %d\n" % face for face in faces)
    points = [[random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(2, 8)] for _ in range(20000)]
    with open("root/tmp/points.xyz", "w") as cloud:
        cloud.writelines("%.6f %.6f %.6f\n" % tuple(p) for p in points)
    subprocess.run(["chroot", "root", "/usr/bin/env", "-C", "/tmp", "LD_LIBRARY_PATH=" + libraries, "HOME=/tmp", "QT_QPA_PLATFORM=offscreen",
                    "CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-C_EXPORT_FMT", "ASC", "-EXT", "txt", "-PREC", "8", "-SEP", "SPACE", "-O",
                    "points.xyz", "-O", "prism.obj", "-C2M_DIST", "-SAVE_CLOUDS", "FILE", "out.txt"], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    outside = beside = wrong = 0
    off = far = 0
    for line in open("root/tmp/out.txt"):
        row = [float(v) for v in line.split()]
        true = distance(row[:3], corners)
        off = max(off, abs(abs(row[-1]) - abs(true)))
        # The ridge itself is nearest.
        if true > 0 and abs(math.hypot(row[0], row[1]) - true) < 1e-6:
            beside += 1
            if row[-1] < 0:
                wrong += 1
                far = max(far, true)
        elif (row[-1] < 0) != (true < 0) and abs(true) > 1e-5:
            outside += 1
    print("ridge of %d degrees: of points outside that are nearest to it %.0f %% count as inside, up to %.1f mm off; %d others; magnitudes %s" %
          (angle, 100 * wrong / beside, far, outside, "right" if off < 2e-6 else "off by %g mm" % off))
P
python3 ridges.py | tee seen
diff seen - <<'E' || exit 1
ridge of 10 degrees: of points outside that are nearest to it 47 % count as inside, up to 4.2 mm off; 0 others; magnitudes right
ridge of 30 degrees: of points outside that are nearest to it 35 % count as inside, up to 4.2 mm off; 0 others; magnitudes right
ridge of 60 degrees: of points outside that are nearest to it 25 % count as inside, up to 4.2 mm off; 0 others; magnitudes right
ridge of 80 degrees: of points outside that are nearest to it 5 % count as inside, up to 4.2 mm off; 0 others; magnitudes right
ridge of 100 degrees: of points outside that are nearest to it 0 % count as inside, up to 0.0 mm off; 0 others; magnitudes right
E
