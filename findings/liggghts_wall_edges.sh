#!/usr/bin/env bash
# LIGGGHTS-PUBLIC 3.8.0 (Debian 12: liggghts 3.8.0+repack1-9+b2), wall of triangles ("fix mesh/surface" with "fix wall/gran ... mesh"): two
# triangles that meet at less than the angle of "curvature", 0.26 degrees by default, count as flat. Over a ridge as flat as that a sphere has
# no force at all as long as the edge is its nearest point (0.9 mm to both sides of a ridge of 0.2 degrees, for a sphere of 1 m): it sinks in. In a
# valley the force is right below that angle and doubles above it, by a step: two contacts where the gap to both triangles is the same. So a
# wall of many small triangles, such as a bone's, has edges that let a sphere in, and edges that are twice as stiff as its faces; a wider
# "curvature" exchanges the one for the other. No message.
# Seen on 2026-12-01: forces of a sphere in units of that on a face, over an edge of N degrees (ridge > 0, valley < 0), as below.
# Usage: findings/liggghts_wall_edges.sh     needs python3, root's apt and chroot; exits with 1 if that changes.
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
"${bookworm[@]}" install --download-only -y liggghts=3.8.0+repack1-9+b2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done
mkdir -p root/tmp

cat >edges.py <<'P'
import math
import subprocess
import sys


def roof(degrees):
    """Two rectangles of 10 x 20 m that meet at x = 0, lower (ridge) or higher at their far ends."""
    low = -10 * math.tan(math.radians(degrees) / 2)
    a, b, c = (-10, -10, low), (0, -10, 0), (10, -10, low)
    d, e, f = (-10, 10, low), (0, 10, 0), (10, 10, low)
    return [(a, b, e), (a, e, d), (b, c, f), (b, f, e)]


def force(degrees, x, options):
    """Upward force on a sphere of radius 0.5 m, its center 0.49 m above the edge, N."""
    with open("root/wall.stl", "w") as file:
        file.write("solid wall\n")
        for triangle in roof(degrees):
            file.write("facet normal 0 0 1\nouter loop\n")
            file.writelines("vertex %r %r %r\n" % corner for corner in triangle)
            file.write("endloop\nendfacet\n")
        file.write("endsolid wall\n")
    with open("root/one.data", "w") as file:
        file.write("one\n\n1 atoms\n1 atom types\n\n-20 20 xlo xhi\n-20 20 ylo yhi\n-20 20 zlo zhi\n\n"
                   "Atoms\n\n1 1 1 1000 %r 0.3 0.49\n" % x)
    with open("root/in", "w") as file:
        file.write("\n".join((
            "atom_style granular", "atom_modify map array", "boundary f f f", "newton off", "communicate single vel yes",
            "units si", "read_data one.data", "neighbor 0.1 bin",
            "fix m1 all property/global youngsModulus peratomtype 1e7",
            "fix m2 all property/global poissonsRatio peratomtype 0.3",
            "fix m3 all property/global coefficientRestitution peratomtypepair 1 0.9",
            "fix m4 all property/global coefficientFriction peratomtypepair 1 0",
            "pair_style gran model hertz tangential history", "pair_coeff * *", "timestep 1e-9",
            "fix wall all mesh/surface file wall.stl type 1 " + options,
            "fix push all wall/gran model hertz tangential history mesh n_meshes 1 meshes wall", "fix move all nve/sphere",
            "dump d all custom 1 forces fz", "dump_modify d format %g", "run 1", "")))
    done = subprocess.run(["chroot", "root", "/usr/bin/liggghts", "-in", "in", "-log", "none"], capture_output=True)
    if done.returncode:
        sys.exit(done.stdout.decode(errors="replace") + done.stderr.decode(errors="replace"))
    return float(open("root/forces").read().split("\n")[9])


face = force(0, 5, "")
for degrees in (1, 0.2, 0, -0.2, -0.3, -1):
    print("%g degrees: %.2f" % (degrees, force(degrees, 0, "") / face))
print("0.2 degrees, 0.1 mm and 1 mm beside it: %.2f, %.2f" % tuple(force(0.2, x, "") / face for x in (1e-4, 1e-3)))
print("1 and -1 degrees, curvature 2: %.2f, %.2f" % tuple(force(d, 0, "curvature 2") / face for d in (1, -1)))
P
OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 python3 edges.py | tee seen
diff seen - <<'E' || exit 1
1 degrees: 1.00
0.2 degrees: 0.00
0 degrees: 1.00
-0.2 degrees: 1.00
-0.3 degrees: 2.00
-1 degrees: 2.01
0.2 degrees, 0.1 mm and 1 mm beside it: 0.00, 1.00
1 and -1 degrees, curvature 2: 0.00, 1.00
E
