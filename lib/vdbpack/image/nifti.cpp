#include "vdbpack/image/nifti.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/header_checks.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <nifti2_io.h>
#include <pugixml.hpp>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

struct FreeNifti {
    void operator()(nifti_image* image) const { nifti_image_free(image); }
};
using Nifti = std::unique_ptr<nifti_image, FreeNifti>;

/// The unit of the file; empty: it states none.
const char* unitOf(const nifti_image& nifti) {
    switch (nifti.xyz_units) {
        case NIFTI_UNITS_METER:
            return "m";
        case NIFTI_UNITS_MM:
            return "mm";
        case NIFTI_UNITS_MICRON:
            return "um";
        default:
            return "";
    }
}

/// From indices to the world of NIfTI (RAS) as one of DICOM (LPS).
ImageGrid gridOf(const nifti_dmat44& m, double unit) {
    ImageGrid grid;
    for (int row = 0; row < 3; ++row) {
        const double sign = row < 2 ? -unit : unit;
        for (int axis = 0; axis < 3; ++axis)
            grid.step[static_cast<std::size_t>(axis)][row] = sign * m.m[row][axis];
        grid.origin[row] = sign * m.m[row][3];
    }
    return grid;
}

/// The names in a table of labels, as programs of Connectome Workbench, nibabel and
/// TotalSegmentator have it in an extension of the header: <Label
/// Key="25"><![CDATA[sacrum]]></Label>.
std::vector<LabelName> labelNames(const nifti_image& nifti) {
    std::vector<LabelName> names;
    for (int k = 0; k < nifti.num_ext; ++k) {
        const nifti1_extension& extension = nifti.ext_list[k];
        const std::string_view text(extension.edata, static_cast<std::size_t>(extension.esize) - 8);
        pugi::xml_document xml;
        // Blanks and zeros may follow.
        if (!xml.load_buffer(text.data(), text.find_last_of('>') + 1)) continue;
        for (const pugi::xpath_node& found : xml.select_nodes("//LabelTable/Label")) {
            const pugi::xml_node label = found.node();
            if (const auto value = label.attribute("Key").as_llong())
                names.push_back({std::string(trimmed(label.text().get())), value, 0});
        }
    }
    return names;
}

/// Warns of a qform that says something else than the sform.
void warnOfOther(const ImageGrid& sform, const ImageGrid& qform, const std::string& path,
                 const Callbacks& callbacks) {
    constexpr double kOtherVoxel = 0.01, kElsewhere = 0.1;  // of its volume, and voxels
    const double volume = std::fabs(sform.signedVoxelVolume()),
                 other = std::fabs(qform.signedVoxelVolume());
    const double off = cornersApart(sform, qform);
    if (std::fabs(other - volume) > kOtherVoxel * volume)
        callbacks.warn(fmt::format(
            "{}: its voxels have {:.4g} mm³ by its sform, which is used, and {:.4g} mm³ by its "
            "qform; if that is their size, remove the sform (code 0)",
            path, volume, other));
    else if (off > kElsewhere)
        callbacks.warn(fmt::format(
            "{}: its sform and its qform place it {:.3g} voxels apart; the sform is used", path,
            off));
}

/// Reads the numbers as they are; niftilib would make those that are not finite 0.
void readVoxels(const nifti_image& nifti, const std::string& path, Image& image) {
    const std::string file = nifti.iname ? nifti.iname : path;
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> voxels(gzopen(file.c_str(), "rb"), gzclose);
    if (!voxels) throw IoError(file + ": cannot be opened for reading");
    const std::size_t width = bytesOf(image.type), bytes = image.values() * width;
    bool whole = gzseek(voxels.get(), static_cast<z_off_t>(nifti.iname_offset), SEEK_SET) >= 0;
    constexpr std::size_t kGzipPiece = std::size_t{1} << 30;
    for (std::size_t at = 0; whole && at < bytes; at += kGzipPiece) {
        const auto piece = static_cast<unsigned>(std::min(kGzipPiece, bytes - at));
        whole = gzread(voxels.get(), image.bytes.get() + at, piece) == static_cast<int>(piece);
    }
    if (!whole) throw InputError(path + ": ends before its last voxel" + kDamaged);
    if (width > 1 && nifti.byteorder != nifti_short_order())
        nifti_swap_Nbytes(static_cast<std::int64_t>(image.values()), static_cast<int>(width),
                          image.bytes.get());
}

}  // namespace

Image readNifti(const std::string& path, const ImageReadOptions& options) {
    std::array<bool, 3> known = checkNiftiHeader(path);
    nifti_set_debug_level(0);
    const Nifti nifti(nifti_image_read(path.c_str(), 0));
    if (!nifti) throw InputError(path + ": is no NIfTI image, or its header is damaged");
    for (int d = 4; d <= 7; ++d)
        if (nifti->ndim >= d && nifti->dim[d] > 1)
            throw InputError(fmt::format(
                "{}: has {} dimensions, {} values along the fourth; give an image of one volume",
                path, nifti->ndim, nifti->dim[4]));
    std::array<std::size_t, 3> size{};
    for (int d = 0; d < 3; ++d)
        size[static_cast<std::size_t>(d)] = d < nifti->ndim && nifti->dim[d + 1] > 0
                                                ? static_cast<std::size_t>(nifti->dim[d + 1])
                                                : 1;
    const Callbacks& callbacks = options.callbacks;
    const double stated = unitFactor(unitOf(*nifti), path, callbacks);
    const double unit = stated > 0 ? stated : 1;
    ImageGrid grid;
    if (nifti->sform_code > 0) {
        grid = gridOf(nifti->sto_xyz, unit);
        grid.size = size;
        ImageGrid other = gridOf(nifti->qto_xyz, unit);
        other.size = size;
        if (nifti->qform_code > 0) warnOfOther(grid, other, path, callbacks);
    } else {
        grid = gridOf(nifti->qto_xyz, unit);
        grid.size = size;
        if (nifti->qform_code <= 0)
            callbacks.warn(
                path +
                ": has neither sform nor qform: where it lies and which side is left is unknown");
    }
    if (nifti->sform_code > 0) known = {true, true, true};
    const bool spaced = applySpacing(grid, options, known, path);
    checkAxes(grid, path, callbacks);
    const NumberType type = voxelType(lowered(nifti_datatype_string(nifti->datatype)), path);
    Image image = allocatedImage(path, grid, 1, type, sizeOf(nifti->iname ? nifti->iname : path));
    callbacks.stopIfCancelled();
    readVoxels(*nifti, path, image);
    if (nifti->scl_slope != 0 && std::isfinite(nifti->scl_slope) &&
        std::isfinite(nifti->scl_inter)) {
        image.slope = nifti->scl_slope;
        image.intercept = nifti->scl_inter;
    }
    image.names = labelNames(*nifti);
    image.isSpaced = spaced;
    image.isSided = nifti->sform_code > 0 || nifti->qform_code > 0;
    image.unit = stated;
    image.format = nifti->nifti_type == NIFTI_FTYPE_ANALYZE ? "Analyze" : "NIfTI";
    return image;
}

}  // namespace vdbpack
