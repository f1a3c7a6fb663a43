// Headers of images that are read or checked here, before a library sees them. All readers get
// every input: what is none of theirs must be refused.
#include "fuzz_file.h"

#include "vdbpack/image/dicom_check.h"
#include "vdbpack/image/header_checks.h"
#include "vdbpack/image/meta_image.h"
#include "vdbpack/image/text_header.h"
#include "vdbpack/io/text.h"

using namespace vdbpack;

namespace {

void requireSound(const Image& image, std::size_t fileBytes) {
    if (!image.bytes || image.values() == 0) fuzz::report("an image without voxels");
    if (image.values() * bytesOf(image.type) > 1100 * fileBytes)
        fuzz::report("more voxels than a file of that size can hold");
    const Vec<3> spacing = image.grid.spacing();
    for (const double s : spacing.c)
        if (!(s > 0) || !std::isfinite(s)) fuzz::report("voxels without a distance");
    if (!isFinite(image.grid.origin)) fuzz::report("an image that lies nowhere");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("i.mha");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] {
        const TextHeader header = readTextHeader(path);
        if (header.end > size || header.longest > size) fuzz::report("a header beyond its file");
        for (const LabelName& label : labelNames(header))
            if (label.name.size() > size) fuzz::report("a name longer than its file");
        bytesOfData(header, path);
        checkNrrdHeader(header, path);
    });
    fuzz::readOrRefuse(path, [&] {
        // Other files are not the fuzzer's.
        if (equalsNoCase(readTextHeader(path).value("elementdatafile"), "local"))
            requireSound(readMetaImage(path, {}), size);
    });
    fuzz::readOrRefuse(path, [&] { checkTiffPages(path); });
    fuzz::readOrRefuse(path, [&] { checkNiftiHeader(path); });
    fuzz::readOrRefuse(path, [&] {
        const DicomKind kind = checkDicom(path);
        if (kind.image && !kind.dicom) fuzz::report("an image without DICOM");
    });
    return 0;
}
