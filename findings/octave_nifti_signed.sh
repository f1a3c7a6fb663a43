#!/usr/bin/env bash
# jnifti 0.6.1 for Octave 9.4 (Debian 13: octave-jnifti 0.6-3; jsonlab 2.9.8, octave-jsonlab 2.9.8-1, has the same functions), niftiread and loadnifti: 16-bit
# integers with a sign, the type of nearly every CT as .nii, are read as those without one. Air of -1000 HU is 64536, so that it lies above each
# threshold for bone: of 64 voxels with 8 of bone, 56 are found. Values from 0 on and all other types are right, and niftiinfo names the type
# uint16 as well. niftiwrite with that niftiinfo writes the bits back as int16, so a copy shows nothing; savenifti writes them
# as uint16. Slope and intercept (scl_slope, scl_inter) are not applied. No message.
# Seen on 2026-12-01: "int16: niftiread uint16 64536 65516 40 1200, ..." and the lines below.
# Usage: findings/octave_nifti_signed.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y octave=9.4.0-1 octave-jnifti=0.6-3 octave-jsonlab=2.9.8-1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >images.py <<'P'
import struct

# 4 x 4 x 4 voxels of 1 mm: 40 of air, 8 of fat, 8 of muscle, 8 of bone.
values = [-1000] * 40 + [-20] * 8 + [40] * 8 + [1200] * 8
for name, code, letter in (("int16", 4, "h"), ("int32", 8, "i"), ("float32", 16, "f"), ("float64", 64, "d")):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 4, 4, 4, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, code, 8 * struct.calcsize(letter))
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
    header[344:348] = b"n+1\0"
    open("root/%s.nii" % name, "wb").write(header + struct.pack("<64" + letter, *values))
P
python3 images.py

cat >root/read.m <<'M'
addpath(glob("/usr/share/octave/packages/jnifti-*"){1});
addpath(glob("/usr/share/octave/packages/jsonlab-*"){1}, "-end");
for type = {"int16", "int32", "float32", "float64"}
    file = ["/" type{1} ".nii"];
    voxels = niftiread(file);
    loaded = loadnifti(file).NIFTIData;
    printf("%s: niftiread %s %g %g %g %g, loadnifti %s %g, niftiinfo %s, above 300: %d of 64\n", type{1}, class(voxels), voxels([1 41 49 57]), ...
           class(loaded), loaded(1), niftiinfo(file).Datatype, sum(voxels(:) > 300));
end
voxels = niftiread("/int16.nii");
printf("typecast to int16: %d %d %d %d\n", typecast(voxels(:), "int16")([1 41 49 57]));
niftiwrite(voxels, "/copy.nii", niftiinfo("/int16.nii"));
savenifti(voxels, "/saved.nii");
M
libraries=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env HOME=/tmp LD_LIBRARY_PATH=$libraries/blas:$libraries/lapack octave-cli --no-window-system --norc /read.m | tee seen
for file in copy saved; do
    echo "type of $file: $(od -An -t d2 -j 70 -N 2 root/$file.nii)" | tee -a seen
done
diff seen - <<'E' || exit 1
int16: niftiread uint16 64536 65516 40 1200, loadnifti uint16 64536, niftiinfo uint16, above 300: 56 of 64
int32: niftiread int32 -1000 -20 40 1200, loadnifti int32 -1000, niftiinfo int32, above 300: 8 of 64
float32: niftiread single -1000 -20 40 1200, loadnifti single -1000, niftiinfo single, above 300: 8 of 64
float64: niftiread double -1000 -20 40 1200, loadnifti double -1000, niftiinfo double, above 300: 8 of 64
typecast to int16: -1000 -20 40 1200
type of copy:       4
type of saved:     512
E
