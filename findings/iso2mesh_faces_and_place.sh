#!/usr/bin/env bash
# iso2mesh 1.9.8 for Octave 9.4 (Debian 13: octave-iso2mesh 1.9.8+ds-2, iso2mesh-tools likewise), v2m(..., 'cgalmesh') of a label map: the third
# result, the faces, has each face twice, both times in the same direction, and next to half of the faces look inward. A .stl that savestl writes of
# them has twice the area and, by the sum over its triangles, 0.1 of the volume. volface of the tetrahedra has each once, facing outward.
# A and B of the options, which are to carry voxels to millimeters, move meshes: half a voxel and one voxel are added after A, as 0.5 and 1 of the new
# unit. A block at 0.5 to 1.5 mm in voxels of 0.1 mm is at 0.95 to 1.95 by 'cgalmesh' and at -0.4 to 0.6 by v2s(..., 'cgalsurf'), 13 voxels
# apart. With voxels of 1 mm both are right; so is a mesh without A, times the voxel size. No message.
# Seen on 2026-12-01: "faces: each 2 times, ..." and the lines below.
# Usage: findings/iso2mesh_faces_and_place.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y octave=9.4.0-1 octave-iso2mesh=1.9.8+ds-2 iso2mesh-tools=1.9.8+ds-2 octave-jsonlab=2.9.8-1 dash debianutils base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

ln -sf dash root/usr/bin/sh
ln -sf which.debianutils root/usr/bin/which
mkdir -p root/tmp

cat >root/block.m <<'M'
addpath(glob("/usr/share/octave/packages/jsonlab-*"){1}, glob("/usr/share/octave/packages/iso2mesh-*"){1});
function [area, volume] = sums(node, face)
  a = node(face(:, 1), 1:3);
  b = node(face(:, 2), 1:3);
  c = node(face(:, 3), 1:3);
  area = sum(norm(cross(b - a, c - a), 2, "rows")) / 2;
  volume = sum(dot(a, cross(b, c), 2)) / 6;
end
function direction = turns(face)
  direction = zeros(rows(face), 1);
  for i = 1:rows(face)
    [~, order] = sort(face(i, :));
    direction(i) = det(eye(3)(order, :));
  end
end

block = zeros(20, 22, 24, "uint8");
block(6:15, 8:17, 9:12) = 1;
[node, elem, face] = v2m(block, [], struct("radbound", 1.5), 5, "cgalmesh");
face = face(:, 1:3);
[distinct, ~, pair] = unique(sort(face, 2), "rows");
outer = volface(elem(:, 1:4));
[area, volume] = sums(node, face);
[right_area, right_volume] = sums(node, outer);
printf("seen faces: each %s times, %d pairs in opposite directions\n", mat2str(unique(accumarray(pair, 1))'), sum(accumarray(pair, turns(face)) == 0));
printf("seen faces, times those of volface: number %g, area %.1f, volume %.1f\n", rows(face) / rows(outer), area / right_area, volume / right_volume);

for size = [1, 0.1]
  options = struct("radbound", 1.5, "A", size * eye(3), "B", [0; 0; 0]);
  mesh = v2m(block, [], options, 5, "cgalmesh");
  surface = v2s(block, 0.5, options, "cgalsurf");
  printf("seen A of %g: cgalmesh %.1f to %.1f voxels, cgalsurf %.1f to %.1f voxels along x\n", size, ...
         min(mesh(:, 1)) / size, max(mesh(:, 1)) / size, min(surface(:, 1)) / size, max(surface(:, 1)) / size);
end
M
libraries=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env HOME=/tmp LD_LIBRARY_PATH=$libraries/blas:$libraries/lapack octave-cli --no-window-system --norc /block.m >all
sed -n 's/^seen //p' all | tee seen
diff seen - <<'E' || exit 1
faces: each 2 times, 0 pairs in opposite directions
faces, times those of volface: number 2, area 2.0, volume 0.1
A of 1: cgalmesh 5.0 to 15.0 voxels, cgalsurf 5.0 to 15.0 voxels along x
A of 0.1: cgalmesh 9.5 to 19.5 voxels, cgalsurf -4.0 to 6.0 voxels along x
E
