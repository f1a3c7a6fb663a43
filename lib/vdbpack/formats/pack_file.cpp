#include "vdbpack/formats/pack_file.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_parts.h"
#include "vdbpack/formats/pack_target.h"
#include "vdbpack/formats/with_images.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace vdbpack {

namespace {

/// Before what a generator states of the origin of its packs.
constexpr const char* kAxesWord = "; axes ";
constexpr const char* kContactsWord = "; contact tolerance ";
constexpr const char* kInterfacesWord = "; interface tolerance ";
constexpr const char* kShearWord = "; bond shear ";

/// Whether a program that reads the format repeats the cell itself.
bool isOfSimulation(PackFormat format) {
    return format == PackFormat::yade || format == PackFormat::spherePack ||
           format == PackFormat::lammpsData || format == PackFormat::lammpsBonds;
}

}  // namespace

template <int Dim>
void checkPack(const Pack<Dim>& pack) {
    const std::size_t n = pack.spheres.size();
    forEachAttribute(pack, [n](std::string_view name, const auto& values) {
        if (!values.empty() && values.size() != n)
            throw ParameterError(fmt::format(
                "pack attribute '{}' has {} values for {} spheres; give one each, or none", name,
                values.size(), n));
    });
    for (std::size_t i = 0; i < n; ++i) {
        const auto& s = pack.spheres[i];
        // Larger ones do not fit a float in every unit.
        bool sound = s.radius > 1e-30 && s.radius < 1e30;
        for (int d = 0; d < Dim; ++d) sound = sound && std::abs(s.center[d]) < 1e30;
        if (!sound)
            throw ParameterError(
                fmt::format("{} {} has radius {} mm and x = {} mm; a positive radius and finite "
                            "lengths below 1e30 mm are needed",
                            Measure<Dim>::kSphere, i, s.radius, s.center[0]));
    }
    if (!(std::abs(pack.sliceHeight) < 1e30))
        throw ParameterError("the height of the slice is not finite; give it in mm");
}

template void checkPack<2>(const Pack<2>&);
template void checkPack<3>(const Pack<3>&);

double pointVoxelSize(double count, double measure, int dim) {
    if (!(count > 0) || !(measure > 0) || !std::isfinite(measure / count)) return 1;
    return std::exp2(std::round(std::log2(8 * measure / count) / dim));
}

void requireVdbVoxel(double edge, Unit unit, const std::string& file) {
    const double written = fromMillimeters(edge, unit);
    if (!(written > 0) || written >= kSmallestVdbVoxel) return;
    throw ParameterError(fmt::format(
        "{}: voxels of {:.4g} {} are too small for OpenVDB, which takes none below {:.3g}: set "
        "`outUnit` to {}, or larger voxels",
        file, written, unitName(unit), kSmallestVdbVoxel,
        unit == Unit::millimeter || unit == Unit::micrometer ? "um" : "mm"));
}

std::string generatorWith(const std::string& program, const PackOrigin& origin) {
    std::string text = program;
    if (!origin.axes.empty()) text += kAxesWord + origin.axes;
    if (origin.contactTolerance > 0)
        text += fmt::format("{}{}", kContactsWord, origin.contactTolerance);
    if (origin.interfaceTolerance > origin.contactTolerance)
        text += fmt::format("{}{}", kInterfacesWord, origin.interfaceTolerance);
    if (origin.shearRatio > 0) text += fmt::format("{}{}", kShearWord, origin.shearRatio);
    return text;
}

PackOrigin originIn(std::string_view generator) {
    const auto after = [&](std::string_view word) {
        const auto at = generator.find(word);
        if (at == std::string_view::npos) return std::string_view();
        const std::string_view rest = generator.substr(at + word.size());
        return rest.substr(0, rest.find_first_of("; \"\r\n"));
    };
    const auto numberAfter = [&](const char* word) {
        double value = 0;
        return parseNumber(after(word), value) && std::isfinite(value) && value > 0 ? value : 0;
    };
    const std::string axes(after(kAxesWord));
    return {axes == "LPS" || axes == "RAS" ? axes : "", numberAfter(kContactsWord),
            numberAfter(kInterfacesWord), numberAfter(kShearWord)};
}

template <int Dim>
void writePack(const Pack<Dim>& pack, const std::string& file, const PackWriteOptions& options) {
    const PackTarget t = targetToWrite(file, Dim);
    checkPack(pack);
    if (!(options.pointVoxel >= 0) || !std::isfinite(options.pointVoxel))
        throw ParameterError(fmt::format(
            "voxel edge of the point grid is {} mm; give a positive length, or 0 to derive it",
            options.pointVoxel));
    const auto checkDensity = [](double density) {
        if (!(density >= 0) || !std::isfinite(density))
            throw ParameterError(
                fmt::format("density of the spheres is {} kg/m³; give a positive one", density));
    };
    checkDensity(options.particleDensity);
    for (const auto& [material, density] : options.materialDensity) checkDensity(density);
    if (options.frame) {
        const Vec<2> size = options.frame->size();
        if (!(size[0] > 0 && size[0] < 1e30 && size[1] > 0 && size[1] < 1e30))
            throw ParameterError(
                fmt::format("the frame of the picture is {} x {} mm; give two positive lengths",
                            size[0], size[1]));
    }
    if (options.images && pack.cell.any() && !isOfSimulation(t.format)) {
        writePack(withImages(pack), file, options);
        return;
    }
    const PackView view(pack, options.unit);
    if (t.format == PackFormat::pvtp) return writePvtp(nullptr, view, options, t.path);
    if (t.format == PackFormat::vtkhdf) return writeVtkHdf(nullptr, view, options, t.path);
    OutputFile out(t.path);
    t.write(view, options, out);
    out.commit();
}

template void writePack<2>(const Pack<2>&, const std::string&, const PackWriteOptions&);
template void writePack<3>(const Pack<3>&, const std::string&, const PackWriteOptions&);

Pack<3> readPack(const std::string& file, const PackReadOptions& options) {
    const PackTarget t = targetToRead(file);
    PackReadOptions requested = options;
    requested.requestedUnit = options.unit;
    try {
        return t.read(t.path, requested);
    } catch (const std::bad_alloc&) {
        throw ResourceError(t.path +
                            ": does not fit into memory; read it on a machine that has more");
    }
}

bool isPlane(const Pack<3>& pack) {
    return pack.spheres.size() > 2 &&
           std::all_of(pack.spheres.begin(), pack.spheres.end(), [&](const Sphere<3>& s) {
               return s.center[2] == pack.spheres.front().center[2];
           });
}

Pack<2> asCircles(const Pack<3>& pack) {
    Pack<2> circles;
    circles.spheres.reserve(pack.spheres.size());
    if (!pack.spheres.empty()) circles.sliceHeight = pack.spheres.front().center[2];
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& s = pack.spheres[i];
        // A height that was written in 32 bits and in another unit may come back slightly
        // different.
        const double tolerance = 1e-6 * std::max(s.radius, std::abs(circles.sliceHeight));
        if (std::abs(s.center[2] - circles.sliceHeight) > tolerance)
            throw InputError(
                fmt::format("sphere {} lies at z = {} mm, sphere 0 at {} mm: these are not circles "
                            "of one slice; treat the pack as spheres",
                            i, s.center[2], circles.sliceHeight));
        circles.spheres.push_back({{{s.center[0], s.center[1]}}, s.radius});
    }
    static_cast<PackAttributes&>(circles) = pack;
    circles.origin = pack.origin;
    for (int d = 0; d < 2 && pack.cell.any(); ++d) {
        circles.cell.wraps[static_cast<std::size_t>(d)] = pack.cell.isAlong(d);
        circles.cell.box.lo[d] = pack.cell.box.lo[d];
        circles.cell.box.hi[d] = pack.cell.box.hi[d];
    }
    return circles;
}

}  // namespace vdbpack
