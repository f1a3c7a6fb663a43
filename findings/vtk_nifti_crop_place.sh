#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1; vedo 2025.5.3, which writes by it, likewise): vtkNIFTIImageWriter writes the image's origin as the place
# of the first voxel of the file and leaves out the extent, which counts from the origin. What vtkExtractVOI has cut out, as a single bone from
# a CT, has an extent that does not begin at 0: in the .nii it lies where the whole image began, here 20, 25 and 30 mm off, and an image
# padded by vtkImageConstantPad is off by the padding. .mha, .vtk and .vti keep the place. A reader's matrix given to the
# writer (SetQFormMatrix) changes nothing; vtkImageChangeInformation with SetOutputExtentStart(0, 0, 0) and SetOutputOrigin to the place of
# the first voxel helps. The unit of length (xyzt_units) is written as unknown. No message.
# Seen on 2026-12-01: "cut out: .nii 10 20 30, .mha 30 45 60, ..." and the lines below.
# Usage: findings/vtk_nifti_crop_place.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

cat >root/crop.py <<'P'
import re
import struct
import sys

from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkMetaImageWriter, vtkNIFTIImageReader, vtkNIFTIImageWriter
from vtkmodules.vtkIOLegacy import vtkStructuredPointsWriter
from vtkmodules.vtkImagingCore import vtkExtractVOI, vtkImageChangeInformation, vtkImageConstantPad


def written(image, writer, file):
    writer.SetFileName(file)
    writer.SetInputData(image)
    writer.Write()
    return open(file, "rb").read()


def nii(image, matrix=None):
    """Place of the first voxel, by the standard: that of the qform, as there is no sform."""
    writer = vtkNIFTIImageWriter()
    if matrix:
        writer.SetQFormMatrix(matrix)
    header = written(image, writer, "/image.nii")
    qform, sform = struct.unpack_from("<2h", header, 252)
    if qform != 1 or sform != 0:
        sys.exit("other forms: %d %d" % (qform, sform))
    return "%g %g %g" % struct.unpack_from("<3f", header, 268)


def places(image):
    mha = re.search(rb"Offset = (.*)", written(image, vtkMetaImageWriter(), "/image.mha")).group(1).decode()
    vtk = re.search(rb"ORIGIN (.*)", written(image, vtkStructuredPointsWriter(), "/image.vtk")).group(1).decode().strip()
    return ".nii %s, .mha %s, .vtk %s, right: %g %g %g" % (nii(image), mha, vtk, *image.GetPoint(0))


def cut(image):
    voi = vtkExtractVOI()
    voi.SetInputData(image)
    voi.SetVOI(40, 59, 50, 69, 60, 79)
    voi.Update()
    return voi.GetOutput()


whole = vtkImageData()
whole.SetDimensions(100, 100, 100)
whole.SetSpacing(0.5, 0.5, 0.5)
whole.SetOrigin(10, 20, 30)
whole.AllocateScalars(VTK_UNSIGNED_CHAR, 1)
whole.GetPointData().GetScalars().Fill(0)
print("whole:", places(whole))
print("cut out:", places(cut(whole)))

pad = vtkImageConstantPad()
pad.SetInputData(whole)
pad.SetOutputWholeExtent(-4, 103, -4, 103, -4, 103)
pad.Update()
print("padded:", places(pad.GetOutput()))

nii(whole)
reader = vtkNIFTIImageReader()
reader.SetFileName("/image.nii")
reader.Update()
print("read from .nii, cut out, written with the reader's matrix: .nii", nii(cut(reader.GetOutput()), reader.GetQFormMatrix()))

begin = vtkImageChangeInformation()
begin.SetInputData(cut(whole))
begin.SetOutputExtentStart(0, 0, 0)
begin.SetOutputOrigin(*cut(whole).GetPoint(0))
begin.Update()
print("cut out, extent from 0, origin at its first voxel:", places(begin.GetOutput()))
print("unit:", open("/image.nii", "rb").read()[123])
P
chroot root /usr/bin/python3 /crop.py | tee seen
diff seen - <<'E' || exit 1
whole: .nii 10 20 30, .mha 10 20 30, .vtk 10 20 30, right: 10 20 30
cut out: .nii 10 20 30, .mha 30 45 60, .vtk 30 45 60, right: 30 45 60
padded: .nii 10 20 30, .mha 8 18 28, .vtk 8 18 28, right: 8 18 28
read from .nii, cut out, written with the reader's matrix: .nii 10 20 30
cut out, extent from 0, origin at its first voxel: .nii 30 45 60, .mha 30 45 60, .vtk 30 45 60, right: 30 45 60
unit: 0
E
