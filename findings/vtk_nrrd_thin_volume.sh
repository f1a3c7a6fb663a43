#!/usr/bin/env bash
# VTK 9.3.0 (Debian 13: python3-vtk9 9.3.0+dfsg1-4+b1; 9.1.0 of Debian 12 likewise): vtkNrrdReader guesses from the size of the first
# axis whether it counts voxels or components. A volume of grey values with fewer than 10 voxels along its first axis is read as one
# slice: 9 x 12 x 13 voxels become 12 x 13 x 1 of 9 components, with the spacings moved one place on. "kinds: domain domain domain", which
# says that all three axes are of space, does not help. A thin crop about a trabecula is another object then, with no warning.
# On the way: after "import vtk" the name vtkNrrdReader makes a vtkPNrrdReader, which reads nothing at all where no MPI controller is
# set ("No MPI Controller available"); the class imported from vtkmodules.vtkIOImage before that is the plain one.
# Seen on 2026-11-27: "9 x 12 x 13: 12 13 1 components 9 spacing 3 4 1" and "10 x 12 x 13: 10 12 13 components 1 spacing 2 3 4".
# Usage: findings/vtk_nrrd_thin_volume.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >root/thin.py <<'P'
from vtkmodules.vtkIOImage import vtkNrrdReader


def show(width):
    header = (f"NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {width} 12 13\nencoding: raw\n"
              "kinds: domain domain domain\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (0,0,0)\n\n")
    with open("/tmp/thin.nrrd", "wb") as file:
        file.write(header.encode() + bytes(width * 12 * 13))
    reader = vtkNrrdReader()
    reader.SetFileName("/tmp/thin.nrrd")
    reader.Update()
    image = reader.GetOutput()
    print(f"{width} x 12 x 13:", *image.GetDimensions(), "components", image.GetNumberOfScalarComponents(), "spacing",
          *(f"{s:g}" for s in image.GetSpacing()), flush=True)


for width in (2, 9, 10):
    show(width)
import vtk
print("after import vtk:", vtk.vtkNrrdReader().GetClassName())
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env UCX_LOG_LEVEL=fatal LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /thin.py 2>messages | tee seen
diff seen - <<'E' || exit 1
2 x 12 x 13: 12 13 1 components 2 spacing 3 4 1
9 x 12 x 13: 12 13 1 components 9 spacing 3 4 1
10 x 12 x 13: 10 12 13 components 1 spacing 2 3 4
after import vtk: vtkPNrrdReader
E
