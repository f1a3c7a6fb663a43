#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1): vtkSurfaceNets3D, the newest of VTK's ways from a label map to surfaces, lists the corners
# of its faces so that all normals point along +x, +y or +z: on half of them into the solid, also where only one label is asked for. The
# surface is closed, and what relies on the order of corners goes wrong without a message: the volume by vtkMassProperties depends on the
# origin (a block of 1000 mm3 has 1700 near it, and 21700 when moved by 100 mm along each axis). vtkDiscreteFlyingEdges3D, its elder, has none of this.
# vtkPolyDataNormals with ConsistencyOn and AutoOrientNormalsOn is the cure.
# After that cure the default smoothing shows: the block of 10 voxels has 801 mm3 for 1000, a plate of one voxel 41 for 100, and a rod of one
# voxel 0 for 10, since it has become a line; with SmoothingOff these are 1000, 100 and 10.
# Seen on 2026-12-01: "vtkSurfaceNets3D: 600 of 1200 triangles inwards, volume 1700, moved by 100 mm 21700, turned 1000" and the lines below.
# Usage: findings/vtk_surface_nets_sides.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

cat >root/nets.py <<'P'
import itertools

from vtkmodules.vtkCommonCore import VTK_SHORT, vtkLogger
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkMassProperties, vtkPolyDataNormals, vtkSurfaceNets3D, vtkTriangleFilter
from vtkmodules.vtkFiltersGeneral import vtkDiscreteFlyingEdges3D

vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)


def labels(upper, shift=0):
    """An image of 24 x 24 x 24 voxels of 1 mm; label 1 from voxel 4 up to `upper`, along x, y and z."""
    image = vtkImageData()
    image.SetDimensions(24, 24, 24)
    image.SetOrigin(shift, shift, shift)
    image.AllocateScalars(VTK_SHORT, 1)
    image.GetPointData().GetScalars().Fill(0)
    for p in itertools.product(*(range(4, n) for n in upper)):
        image.SetScalarComponentFromDouble(*p, 0, 1)
    return image


def surface(source, image, smoothing=None):
    source.SetInputData(image)
    source.SetValue(0, 1)
    if smoothing is not None:
        source.SetSmoothing(smoothing)
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(source.GetOutputPort())
    triangles.Update()
    return triangles.GetOutput()


def volume(triangles):
    mass = vtkMassProperties()
    mass.SetInputData(triangles)
    mass.Update()
    return "%.0f" % mass.GetVolume()


def turned(triangles):
    normals = vtkPolyDataNormals()
    normals.SetInputData(triangles)
    normals.SplittingOff()
    normals.ConsistencyOn()
    normals.AutoOrientNormalsOn()
    normals.Update()
    return normals.GetOutput()


def inwards(triangles):
    """Triangles of a block whose normals point to the middle of the block."""
    bounds = triangles.GetBounds()
    middle = [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]
    count = 0
    for i in range(triangles.GetNumberOfCells()):
        a, b, c = (triangles.GetPoint(triangles.GetCell(i).GetPointId(k)) for k in range(3))
        u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
        normal = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        count += sum(n * (a[k] + (u[k] + v[k]) / 3 - middle[k]) for k, n in enumerate(normal)) < 0
    return count


for name, source, smoothing in (("vtkSurfaceNets3D", vtkSurfaceNets3D, False), ("vtkDiscreteFlyingEdges3D", vtkDiscreteFlyingEdges3D, None)):
    near, far = (surface(source(), labels((14, 14, 14), shift), smoothing) for shift in (0, 100))
    print("%s: %d of %d triangles inwards, volume %s, moved by 100 mm %s, turned %s" %
          (name, inwards(near), near.GetNumberOfCells(), volume(near), volume(far), volume(turned(near))))
for name, upper in (("block", (14, 14, 14)), ("plate", (14, 14, 5)), ("rod", (14, 5, 5))):
    print(name, "turned, by default and with SmoothingOff:",
          ", ".join(volume(turned(surface(vtkSurfaceNets3D(), labels(upper), smoothing))) for smoothing in (None, False)))
P
chroot root /usr/bin/python3 /nets.py | tee seen
diff seen - <<'E' || exit 1
vtkSurfaceNets3D: 600 of 1200 triangles inwards, volume 1700, moved by 100 mm 21700, turned 1000
vtkDiscreteFlyingEdges3D: 0 of 1196 triangles inwards, volume 986, moved by 100 mm 986, turned 986
block turned, by default and with SmoothingOff: 801, 1000
plate turned, by default and with SmoothingOff: 41, 100
rod turned, by default and with SmoothingOff: 0, 10
E
