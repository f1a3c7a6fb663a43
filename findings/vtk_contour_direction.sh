#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1): an image has a direction matrix since VTK 9, and the filters that make a surface of
# it differ over it. vtkContourFilter passes it over, so that the bone lies beside its own outline; with FastMode, which is there
# for speed, it places the same surface right. vtkFlyingEdges3D, vtkMarchingCubes and vtkDiscreteMarchingCubes place it right too,
# and where the matrix mirrors (an odd number of axes turned, or two exchanged) those and FastMode leave the triangles' order as it was:
# all normals point into the bone and its volume is negative. And vtkMetaImageWriter states "TransformMatrix = 1 0 0 0 1 0 0 0 1" whatever
# the matrix, with an offset that is right for the true one, while vtkMetaImageReader passes over the matrix that a file has. No warning in
# all of this. A .vti file keeps the matrix.
# Seen on 2026-11-30: with x turned, voxels at x = 91.5 to 97.5: vtkContourFilter 102.5 to 108.5, vtkFlyingEdges3D right, volume -207.7.
# Usage: findings/vtk_contour_direction.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

cat >root/direction.py <<'P'
import re

from vtkmodules.vtkCommonCore import vtkFloatArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkFlyingEdges3D, vtkMarchingCubes, vtkTriangleFilter
from vtkmodules.vtkFiltersGeneral import vtkDiscreteMarchingCubes
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOImage import vtkMetaImageReader, vtkMetaImageWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter

values = vtkFloatArray()
for z in range(12):
    for y in range(12):
        for x in range(12):
            values.InsertNextValue(3 <= x < 9 and 3 <= y < 9 and 3 <= z < 9)


def image(x, y):
    made = vtkImageData()
    made.SetDimensions(12, 12, 12)
    made.SetOrigin(100, 0, 0)
    made.SetDirectionMatrix(x, 0, 0, 0, y, 0, 0, 0, 1)
    made.GetPointData().SetScalars(values)
    return made


def surface(name, source, of):
    source.SetInputData(of)
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(source.GetOutputPort())
    triangles.Update()
    mesh, volume = triangles.GetOutput(), 0
    for k in range(mesh.GetNumberOfCells()):
        a, b, c = (mesh.GetPoint(mesh.GetCell(k).GetPointId(i)) for i in range(3))
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    print("  %s: x %g to %g, volume %.4g" % (name, *mesh.GetBounds()[:2], volume))


for name, x, y in (("identity", 1, 1), ("turned about z", -1, -1), ("mirrored in x", -1, 1)):
    of = image(x, y)
    print(name)
    outline = vtkGeometryFilter()
    outline.SetInputData(of)
    outline.Update()
    print("  outline: x %g to %g" % outline.GetOutput().GetBounds()[:2])
    for filter_class, value in ((vtkContourFilter, 0.5), (vtkFlyingEdges3D, 0.5), (vtkMarchingCubes, 0.5), (vtkDiscreteMarchingCubes, 1)):
        source = filter_class()
        source.SetValue(0, value)
        surface(filter_class.__name__, source, of)
    fast = vtkContourFilter()
    fast.SetValue(0, 0.5)
    fast.FastModeOn()
    surface("vtkContourFilter, FastMode", fast, of)
    files = (("mhd", vtkMetaImageWriter(), vtkMetaImageReader()), ("vti", vtkXMLImageDataWriter(), vtkXMLImageDataReader()))
    for kind, writer, reader in files:
        writer.SetFileName("/tmp/image." + kind)
        writer.SetInputData(of)
        writer.Write()
        if kind == "mhd":
            text = open("/tmp/image.mhd").read()
            print("  written:", *re.findall("(?:TransformMatrix|Offset).*", text))
            open("/tmp/image.mhd", "w").write(re.sub("TransformMatrix.*", f"TransformMatrix = {x} 0 0 0 {y} 0 0 0 1", text))
        reader.SetFileName("/tmp/image." + kind)
        reader.Update()
        print("  right .%s read: x %g to %g" % (kind, *reader.GetOutput().GetBounds()[:2]))
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack:$lib/openblas-pthread:$lib/hdf5/serial HOME=/tmp \
    /usr/bin/python3 /direction.py | tee seen
diff seen - <<'E' || exit 1
identity
  outline: x 100 to 111
  vtkContourFilter: x 102.5 to 108.5, volume 207.7
  vtkFlyingEdges3D: x 102.5 to 108.5, volume 207.7
  vtkMarchingCubes: x 102.5 to 108.5, volume 207.7
  vtkDiscreteMarchingCubes: x 102.5 to 108.5, volume 207.7
  vtkContourFilter, FastMode: x 102.5 to 108.5, volume 207.7
  written: TransformMatrix = 1 0 0 0 1 0 0 0 1 Offset = 100 0 0
  right .mhd read: x 100 to 111
  right .vti read: x 100 to 111
turned about z
  outline: x 89 to 100
  vtkContourFilter: x 102.5 to 108.5, volume 207.7
  vtkFlyingEdges3D: x 91.5 to 97.5, volume 207.7
  vtkMarchingCubes: x 91.5 to 97.5, volume 207.7
  vtkDiscreteMarchingCubes: x 91.5 to 97.5, volume 207.7
  vtkContourFilter, FastMode: x 91.5 to 97.5, volume 207.7
  written: TransformMatrix = 1 0 0 0 1 0 0 0 1 Offset = 100 0 0
  right .mhd read: x 100 to 111
  right .vti read: x 89 to 100
mirrored in x
  outline: x 89 to 100
  vtkContourFilter: x 102.5 to 108.5, volume 207.7
  vtkFlyingEdges3D: x 91.5 to 97.5, volume -207.7
  vtkMarchingCubes: x 91.5 to 97.5, volume -207.7
  vtkDiscreteMarchingCubes: x 91.5 to 97.5, volume -207.7
  vtkContourFilter, FastMode: x 91.5 to 97.5, volume -207.7
  written: TransformMatrix = 1 0 0 0 1 0 0 0 1 Offset = 100 0 0
  right .mhd read: x 100 to 111
  right .vti read: x 89 to 100
E
