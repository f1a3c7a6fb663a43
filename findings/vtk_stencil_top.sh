#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1): vtkPolyDataToImageStencil, the usual way from a surface to a mask, keeps voxels whose
# centers lie on a face, on both sides in x and y, but in z not those on the upper face. A block of 4 mm whose faces lie on centers of
# voxels of 1 mm is 5 x 5 x 4 voxels, 100 mm3 for 64, and a plate of 1 mm is two voxels thick across x or y and one across z. So blocks
# stacked in z share no voxel, while side by side they do. SetTolerance(0) makes it half-open along all axes: 4 x 4 x 4, as it is between
# centers. No message.
# Seen on 2026-12-01: "faces on centers: 5 x 5 x 4", "with tolerance 0.001, 0: 5 x 5 x 4, 4 x 4 x 4" and the lines below.
# Usage: findings/vtk_stencil_top.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-vtk9=9.3.0+dfsg1-4+b1 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

cat >root/stencil.py <<'P'
import itertools

from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkFiltersSources import vtkCubeSource
from vtkmodules.vtkImagingStencil import vtkImageStencil, vtkPolyDataToImageStencil


def mask(x, y, z, tolerance=None):
    """Layers along x, y and z of a block in an image of voxels of 1 mm, with centers at whole numbers."""
    block = vtkCubeSource()
    block.SetBounds(*x, *y, *z)
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(block.GetOutputPort())
    stencil = vtkPolyDataToImageStencil()
    stencil.SetInputConnection(triangles.GetOutputPort())
    stencil.SetOutputWholeExtent(-2, 8, -2, 8, -2, 8)
    if tolerance is not None:
        stencil.SetTolerance(tolerance)
    image = vtkImageData()
    image.SetExtent(-2, 8, -2, 8, -2, 8)
    image.AllocateScalars(VTK_UNSIGNED_CHAR, 1)
    image.GetPointData().GetScalars().Fill(1)
    masked = vtkImageStencil()
    masked.SetInputData(image)
    masked.SetStencilConnection(stencil.GetOutputPort())
    masked.SetBackgroundValue(0)
    masked.Update()
    voxels = [p for p in itertools.product(range(-2, 9), repeat=3) if masked.GetOutput().GetScalarComponentAsDouble(*p, 0)]
    return " x ".join(str(len({p[axis] for p in voxels})) for axis in range(3))


whole, between = (0, 4), (0.25, 4.25)
print("faces on centers:", mask(whole, whole, whole))
print("with tolerance 0.001, 0:", mask(whole, whole, whole, 1e-3) + ",", mask(whole, whole, whole, 0))
print("faces between centers:", mask(between, between, between))
print("thin plates on centers, in x, y, z:", ", ".join((mask((2, 3), whole, whole), mask(whole, (2, 3), whole), mask(whole, whole, (2, 3)))))
print("stacked in z, 0 to 2 and 2 to 4:", ", ".join((mask(whole, whole, (0, 2)), mask(whole, whole, (2, 4)))))
P
chroot root /usr/bin/python3 /stencil.py | tee seen
diff seen - <<'E' || exit 1
faces on centers: 5 x 5 x 4
with tolerance 0.001, 0: 5 x 5 x 4, 4 x 4 x 4
faces between centers: 4 x 4 x 4
thin plates on centers, in x, y, z: 2 x 5 x 4, 5 x 2 x 4, 5 x 5 x 1
stacked in z, 0 to 2 and 2 to 4: 5 x 5 x 2, 5 x 5 x 2
E
