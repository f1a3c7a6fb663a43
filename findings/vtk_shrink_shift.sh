#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1): vtkImageShrink3D, which makes a large CT smaller by taking the mean of each block of voxels
# (its default), puts that mean where the first voxel of the block was, not at the middle of the block: the spacing is right, and the origin
# is that of the input. The object moves towards the origin by half a voxel of the input for a factor of 2 and by one and a half for 4, along
# all axes; maximum, minimum and median do the same. A block of voxels whose middle is at 19.5 mm has it at 19 and 18. A surface of
# the small volume lies beside the mask, the mesh or the large volume by as much, and its volume is right. vtkImageMagnify without
# interpolation, its default, moves it the other way, by 0.25 and 0.375 mm for factors of 2 and 4; vtkImageResize with BorderOn keeps the
# middle. No message.
# Seen on 2026-12-01: "vtkImageShrink3D by 4: voxels of 4, origin 10, volume by mean 512, middle by mean: 18, ..." and the lines below.
# Usage: findings/vtk_shrink_shift.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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

cat >root/shrink.py <<'P'
import itertools

from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingCore import vtkImageMagnify, vtkImageResize, vtkImageShrink3D

image = vtkImageData()
image.SetDimensions(24, 24, 24)
image.SetOrigin(10, 10, 10)
image.AllocateScalars(VTK_FLOAT, 1)
image.GetPointData().GetScalars().Fill(0)
for p in itertools.product(range(6, 14), repeat=3):
    image.SetScalarComponentFromDouble(*p, 0, 1)


def measured(volume):
    """Center of mass of an image along x, and the sum of its values in mm3."""
    weights = [0] * volume.GetDimensions()[0]
    for p in itertools.product(*(range(n) for n in volume.GetDimensions())):
        weights[p[0]] += volume.GetScalarComponentAsDouble(*p, 0)
    places = [volume.GetOrigin()[0] + i * volume.GetSpacing()[0] for i in range(len(weights))]
    middle = sum(w * x for w, x in zip(weights, places)) / sum(weights)
    return round(middle, 4), round(sum(weights) * volume.GetSpacing()[0] ** 3, 2)


def made(source):
    source.SetInputData(image)
    source.Update()
    return source.GetOutput()


print("input: voxels of 1, origin 10, volume %g, middle at %g" % measured(image)[::-1])
for factor in (2, 4):
    places = []
    for way in ("Mean", "Maximum", "Minimum", "Median"):
        shrink = vtkImageShrink3D()
        shrink.SetShrinkFactors(factor, factor, factor)
        if way != "Mean":
            getattr(shrink, way + "On")()
        small = made(shrink)
        places.append("%s: %g" % (way.lower(), measured(small)[0]))
        if way == "Mean":
            volume = measured(small)[1]
    print("vtkImageShrink3D by %d: voxels of %g, origin %g, volume by mean %g, middle by %s" %
          (factor, small.GetSpacing()[0], small.GetOrigin()[0], volume, ", ".join(places)))
for factor in (2, 4):
    places = []
    for interpolate in (False, True):
        magnify = vtkImageMagnify()
        magnify.SetMagnificationFactors(factor, factor, factor)
        if interpolate:
            magnify.InterpolateOn()
        large = made(magnify)
        places.append("%g" % measured(large)[0])
    print("vtkImageMagnify by %d: voxels of %g, origin %g, middle at %s, with InterpolateOn at %s" %
          (factor, large.GetSpacing()[0], large.GetOrigin()[0], *places))
resize = vtkImageResize()
resize.SetOutputDimensions(12, 12, 12)
resize.BorderOn()
small = made(resize)
print("vtkImageResize by 2, BorderOn: voxels of %g, origin %g, middle at %g" %
      (small.GetSpacing()[0], small.GetOrigin()[0], measured(small)[0]))
P
chroot root /usr/bin/python3 /shrink.py | tee seen
diff seen - <<'E' || exit 1
input: voxels of 1, origin 10, volume 512, middle at 19.5
vtkImageShrink3D by 2: voxels of 2, origin 10, volume by mean 512, middle by mean: 19, maximum: 19, minimum: 19, median: 19
vtkImageShrink3D by 4: voxels of 4, origin 10, volume by mean 512, middle by mean: 18, maximum: 18, minimum: 18, median: 18
vtkImageMagnify by 2: voxels of 0.5, origin 10, middle at 19.75, with InterpolateOn at 19.5
vtkImageMagnify by 4: voxels of 0.25, origin 10, middle at 19.875, with InterpolateOn at 19.5
vtkImageResize by 2, BorderOn: voxels of 2, origin 10.5, middle at 19.5
E
