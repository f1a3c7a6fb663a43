#!/usr/bin/env bash
# pyopenvdb 10.0.1 (Debian 13: python3-openvdb 10.0.1-2.3+b1): copyFromArray takes the shape of a numpy array and not its strides. An
# array in Fortran's order, which is what nibabel gives for every NIfTI file, is read as if it were in C's order: the grid has the
# right size, the right number of voxels and the right mean, and the voxels are scrambled. No error, no warning; the
# binding of Debian 12 does the same. numpy.ascontiguousarray before the call is the cure.
# Seen on 2026-11-27: voxel (1, 0, 0) of an array 4 x 5 x 6 that counts from 0: 30 in C's order, 73 in Fortran's (right: 30).
# Usage: findings/pyopenvdb_array_order.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-openvdb=10.0.1-2.3+b1 python3-nibabel=5.3.2-2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >root/order.py <<'P'
import nibabel
import numpy
import pyopenvdb

numbers = numpy.arange(120, dtype="float32").reshape(4, 5, 6)
nibabel.save(nibabel.Nifti1Image(numbers, numpy.eye(4)), "/tmp/numbers.nii")
read = numpy.asarray(nibabel.load("/tmp/numbers.nii").dataobj)
assert (read == numbers).all()
for name, array in (("made in C's order", numbers), ("read by nibabel", read), ("and made contiguous", numpy.ascontiguousarray(read))):
    grid = pyopenvdb.FloatGrid()
    grid.copyFromArray(array)
    voxels = grid.getAccessor()
    print(f"{name}: size {grid.evalActiveVoxelDim()} voxel (1, 0, 0) is {voxels.getValue((1, 0, 0)):g}")
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /order.py | tee seen
diff seen - <<'E' || exit 1
made in C's order: size (4, 5, 6) voxel (1, 0, 0) is 30
read by nibabel: size (4, 5, 6) voxel (1, 0, 0) is 73
and made contiguous: size (4, 5, 6) voxel (1, 0, 0) is 30
E
