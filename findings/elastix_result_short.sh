#!/usr/bin/env bash
# elastix 5.2.0 (Debian 13: elastix 5.2.0-2; 5.0.1 of Debian 12 likewise): without ResultImagePixelType in the parameter file, elastix and transformix
# write 16-bit integers with a sign, whatever the image was. A micro-CT in unsigned 16 bits comes back with its densest bone below its air,
# 33000 as -32536, and a density of 0 to 1 as 0 everywhere. Values are cut off, not rounded: a label map of 7, moved by half a voxel
# with the default interpolation, has 6 within it. Steps of 0.5 come back as -1 -1 0 0 0 1 1. With
# "float" all is right. No message, exit status 0.
# Seen on 2026-12-01: the lines below.
# Usage: findings/elastix_result_short.sh     needs python3, root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y elastix=5.2.0-2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do
    dpkg -x "$package" root
    rm "$package"
done

mkdir -p root/tmp
cat >images.py <<'P'
import array
import itertools
import subprocess
import sys

kinds = {"MET_UCHAR": "B", "MET_SHORT": "h", "MET_USHORT": "H", "MET_FLOAT": "f"}


def write(name, kind, value):
    """16 x 16 x 16 voxels of 1 mm."""
    open("root/%s.raw" % name, "wb").write(array.array(kinds[kind], (value(x, y, z) for z, y, x in itertools.product(range(16), repeat=3))).tobytes())
    with open("root/%s.mhd" % name, "w") as out:
        out.write("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nElementSpacing = 1 1 1\nOffset = 0 0 0\n"
                  "DimSize = 16 16 16\nElementType = %s\nElementDataFile = %s.raw\n" % (kind, name))


def row(file, digits=2):
    """The type of an image, and its values along x through the middle."""
    header = dict(line.strip().split(" = ") for line in open("root/tmp/%s.mhd" % file))
    values = array.array(kinds[header["ElementType"]], open("root/tmp/" + header["ElementDataFile"], "rb").read())[16 * (8 + 16 * 8):][:16]
    return header["ElementType"], " ".join("%g" % (round(v, digits) + 0.0) for v in values)


def run(program, *options):
    done = subprocess.run(["chroot", "root", "/usr/bin/env", "HOME=/tmp", program, *options, "-out", "/tmp"], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)


def moved(name, shift, extra=""):
    with open("root/moved.txt", "w") as out:
        out.write('(FixedImageDimension 3)\n(MovingImageDimension 3)\n(FixedInternalImagePixelType "float")\n'
                  '(MovingInternalImagePixelType "float")\n(Transform "TranslationTransform")\n(NumberOfParameters 3)\n'
                  '(TransformParameters %g 0 0)\n(InitialTransformParametersFileName "NoInitialTransform")\n(HowToCombineTransforms "Compose")\n'
                  '(Size 16 16 16)\n(Index 0 0 0)\n(Spacing 1 1 1)\n(Origin 0 0 0)\n(Direction 1 0 0 0 1 0 0 0 1)\n(UseDirectionCosines "true")\n'
                  '(ResampleInterpolator "FinalBSplineInterpolator")\n(Resampler "DefaultResampler")\n(DefaultPixelValue 0)\n'
                  '(ResultImageFormat "mhd")\n%s\n' % (shift, extra))
    run("transformix", "-in", "/%s.mhd" % name, "-tp", "/moved.txt")
    return "%s: %s" % row("result")


write("ct", "MET_USHORT", lambda x, y, z: 3000 * x)
write("density", "MET_FLOAT", lambda x, y, z: x / 20)
write("steps", "MET_FLOAT", lambda x, y, z: (x - 8) / 2)
write("label", "MET_UCHAR", lambda x, y, z: 7 * (max(abs(x - 8), abs(y - 8), abs(z - 8)) < 5))
for name, shift in (("ct", 0), ("density", 0), ("steps", 0), ("label", 0.5)):
    print("%s, moved by %g," % (name, shift), moved(name, shift))
print("ct, moved by 0, float,", moved("ct", 0, '(ResultImagePixelType "float")'))

with open("root/fit.txt", "w") as out:
    out.write('(FixedInternalImagePixelType "float")\n(MovingInternalImagePixelType "float")\n(UseDirectionCosines "true")\n'
              '(Registration "MultiResolutionRegistration")\n(Interpolator "LinearInterpolator")\n(ResampleInterpolator "FinalLinearInterpolator")\n'
              '(Resampler "DefaultResampler")\n(FixedImagePyramid "FixedSmoothingImagePyramid")\n(MovingImagePyramid "MovingSmoothingImagePyramid")\n'
              '(Optimizer "RegularStepGradientDescent")\n(Transform "TranslationTransform")\n(Metric "AdvancedMeanSquares")\n'
              '(NumberOfResolutions 1)\n(MaximumNumberOfIterations 1)\n(MaximumStepLength 0.0001)\n(ImageSampler "Full")\n(WriteResultImage "true")\n(ResultImageFormat "mhd")\n')
run("elastix", "-f", "/ct.mhd", "-m", "/ct.mhd", "-p", "/fit.txt")
print("ct, fitted to itself, to hundreds, %s: %s" % row("result.0", -2))
P
python3 images.py | tee seen
diff seen - <<'E' || exit 1
ct, moved by 0, MET_SHORT: 0 3000 6000 9000 12000 15000 18000 21000 24000 27000 30000 -32536 -29536 -26536 -23536 -20536
density, moved by 0, MET_SHORT: 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
steps, moved by 0, MET_SHORT: -4 -3 -3 -2 -2 -1 -1 0 0 0 1 1 2 2 3 3
label, moved by 0.5, MET_SHORT: 0 0 0 3 7 6 7 6 6 7 6 7 3 0 0 0
ct, moved by 0, float, MET_FLOAT: 0 3000 6000 9000 12000 15000 18000 21000 24000 27000 30000 33000 36000 39000 42000 45000
ct, fitted to itself, to hundreds, MET_SHORT: 0 3000 6000 9000 12000 15000 18000 21000 24000 27000 30000 -32500 -29500 -26500 -23500 -20500
E
