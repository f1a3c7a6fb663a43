#!/usr/bin/env bash
# GDCM 3.0.24 (Debian 13: python3-gdcm 3.0.24-5+b3): an Enhanced CT file, all slices in one file, gets its spacing only where the frames
# are equally far apart in the file's order. Where two frames are exchanged, which the standard allows (each frame has its own
# position), or one is missing, ImageReader.Read is true, the message goes to standard error, and all three spacings are 1, those in
# the plane too, although PixelSpacing is one value for all frames. Where the frames run downwards the spacing is negative.
# Seen on 2026-11-27: heights 0 1 2 3: spacing 0.25 0.5 1; 0 2 1 3 and 0 1 3 4: 1 1 1; 3 2 1 0: 0.25 0.5 -1.
# Usage: findings/gdcm_frames_out_of_order.sh     needs root's apt and chroot and Debian 13's packages; exits with 1 if that changes.
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
"${trixie[@]}" install --download-only -y python3-gdcm=3.0.24-5+b3 python3-pydicom=2.4.3-2 base-files coreutils >/dev/null
for package in apt/cache/archives/*.deb; do dpkg -x "$package" root; done

cat >root/frames.py <<'P'
import gdcm
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian


def group(**values):
    inner = Dataset()
    for name, value in values.items():
        setattr(inner, name, value)
    return [inner]


for heights in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 1, 3, 4), (3, 2, 1, 0)):
    file = Dataset()
    file.file_meta = FileMetaDataset()
    file.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    file.is_little_endian, file.is_implicit_VR = True, False
    file.SOPClassUID = file.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2.1"
    file.SOPInstanceUID = file.file_meta.MediaStorageSOPInstanceUID = "2.25.1"
    file.StudyInstanceUID, file.SeriesInstanceUID, file.FrameOfReferenceUID = "2.25.2", "2.25.3", "2.25.4"
    file.Modality, file.PatientName, file.PatientID, file.ImageType = "CT", "a", "1", ["ORIGINAL", "PRIMARY", "VOLUME", "NONE"]
    file.Rows, file.Columns, file.NumberOfFrames, file.SamplesPerPixel = 2, 3, len(heights), 1
    file.PhotometricInterpretation, file.PixelRepresentation = "MONOCHROME2", 1
    file.BitsAllocated, file.BitsStored, file.HighBit = 16, 16, 15
    file.SharedFunctionalGroupsSequence = group(
        PixelMeasuresSequence=group(SliceThickness=1, PixelSpacing=[0.5, 0.25]),
        PlaneOrientationSequence=group(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]),
        PixelValueTransformationSequence=group(RescaleIntercept=0, RescaleSlope=1, RescaleType="HU"))
    file.PerFrameFunctionalGroupsSequence = [
        group(PlanePositionSequence=group(ImagePositionPatient=[10, 20, z]),
              FrameContentSequence=group(StackID="1", InStackPositionNumber=sorted(heights).index(z) + 1))[0] for z in heights]
    file.PixelData = bytes(12 * len(heights))
    file.save_as("/tmp/frames.dcm", write_like_original=False)
    reader = gdcm.ImageReader()
    reader.SetFileName("/tmp/frames.dcm")
    read = reader.Read()
    print(*heights, "read:", read, "spacing:", *(f"{s:g}" for s in reader.GetImage().GetSpacing()))
P
lib=/usr/lib/x86_64-linux-gnu
chroot root /usr/bin/env LD_LIBRARY_PATH=$lib/blas:$lib/lapack /usr/bin/python3 /frames.py 2>messages | tee seen
diff seen - <<'E' || exit 1
0 1 2 3 read: True spacing: 0.25 0.5 1
0 2 1 3 read: True spacing: 1 1 1
0 1 3 4 read: True spacing: 1 1 1
3 2 1 0 read: True spacing: 0.25 0.5 -1
E
