#include "support/dicom_file.h"
#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/image/image_file.h"

#include <zlib.h>

#include <cstring>

namespace {

std::string messageFor(const std::string& path) {
    return messageOf<InputError>([&] { readImage(path); });
}

/// A MetaImage of 2 x 2 x 2 voxels with further lines.
std::string meta(const std::string& lines, const std::string& data = "LOCAL\n12345678") {
    return "ObjectType = Image\n" + lines +
           "BinaryData = True\nElementSpacing = 1 1 1\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
           "ElementDataFile = " +
           data;
}

}  // namespace

TEST_CASE("MetaImage: deflated voxels are read, what does not inflate is refused") {
    const TemporaryFolder folder;
    const std::string voxels = "abcdefgh";
    std::string packed(64, '\0');
    uLongf size = packed.size();
    REQUIRE(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(voxels.data()), voxels.size()) == Z_OK);
    packed.resize(size);
    const std::string path = folder.file("a.mha");
    writeBytes(path, meta("NDims = 3\nCompressedData = True\n", "LOCAL\n" + packed));
    const Image image = readImage(path);
    CHECK(std::memcmp(image.bytes.get(), voxels.data(), voxels.size()) == 0);
    packed[4] = static_cast<char>(packed[4] ^ 0x55);
    writeBytes(path, meta("NDims = 3\nCompressedData = True\n", "LOCAL\n" + packed.substr(0, 6)));
    CHECK_THAT(messageFor(path), Contains("last voxel") && Contains("download it again"));
}

TEST_CASE("MetaImage: headers that lie are refused") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.mhd");
    for (const char* lines :
         {"", "NDims = -1\n", "NDims = 1000000000\n", "NDims = 2\n",
          "NDims = 3\nHeaderSize = 99999999999\n", "NDims = 3\nOffset = 1 nan 0\n",
          "NDims = 3\nElementNumberOfChannels = 0\n"}) {
        CAPTURE(lines);
        writeBytes(path, meta(lines));
        CHECK_FALSE(messageFor(path).empty());
    }
    for (const char* data : {"LIST\nb.raw", "b%n%s.raw 1 3 1", "b%03d.raw 1 3 0"}) {
        CAPTURE(data);
        writeBytes(path, meta("NDims = 3\n", data));
        CHECK_THAT(messageFor(path), Contains("one file"));
    }
}

TEST_CASE("headers that libraries do not survive are refused before") {
    const TemporaryFolder folder;
    writeBytes(folder.file("a.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nkinds: " +
                                          std::string(2000, 'A') + "\nencoding: raw\n\n12345678");
    CHECK_THAT(messageFor(folder.file("a.nrrd")), Contains("line"));
    // A page that follows itself.
    writeBytes(folder.file("a.tif"), std::string("II*\0\10\0\0\0\0\0\10\0\0\0", 14));
    CHECK_THAT(messageFor(folder.file("a.tif")), Contains("circle"));
}

TEST_CASE("DICOM: damaged slices are refused by name, other files are left out") {
    const TemporaryFolder folder;
    const std::string second = dicomSlice("1.5").file();
    writeBytes(folder.file("1.dcm"), dicomSlice("0").file());
    writeBytes(folder.file("2.dcm"), second);
    writeBytes(folder.file("notes.txt"), "no slice");
    CHECK(readImage(folder.file("")).grid.size[2] == 2);
    for (std::size_t size = 140; size < second.size(); size += 7) {
        CAPTURE(size);
        writeBytes(folder.file("2.dcm"), second.substr(0, size));
        CHECK_FALSE(messageFor(folder.file("")).empty());
    }
    for (std::size_t at = 132; at < second.size() - 8; ++at) {
        CAPTURE(at);
        std::string damaged = second;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
        writeBytes(folder.file("2.dcm"), damaged);
        try {
            readImage(folder.file(""));
        } catch (const InputError&) {
        }
    }
}
