#include "vdbpack/image/image_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom.h"
#include "vdbpack/image/dicom_check.h"
#include "vdbpack/image/header_checks.h"
#include "vdbpack/image/itk_image.h"
#include "vdbpack/image/mask_folder.h"
#include "vdbpack/image/meta_image.h"
#include "vdbpack/image/nifti.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// By the numbers in names: slice2 before slice10.
bool inOrder(const std::string& a, const std::string& b) {
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!digit(a[i]) || !digit(b[j])) {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i;
            ++j;
            continue;
        }
        std::size_t m = i, n = j;
        while (m < a.size() && digit(a[m])) ++m;
        while (n < b.size() && digit(b[n])) ++n;
        while (i + 1 < m && a[i] == '0') ++i;
        while (j + 1 < n && b[j] == '0') ++j;
        if (m - i != n - j) return m - i < n - j;
        const int order = a.compare(i, m - i, b, j, n - j);
        if (order != 0) return order < 0;
        i = m;
        j = n;
    }
    return a.size() - i < b.size() - j;
}

/// Whether a name matches a pattern with the wildcard *.
bool matches(const char* name, const char* pattern) {
    if (*pattern == '*')
        return matches(name, pattern + 1) || (*name != 0 && matches(name + 1, pattern));
    if (*pattern == 0 || *name == 0) return *pattern == *name;
    return *name == *pattern && matches(name + 1, pattern + 1);
}

/// The files of a folder whose names are accepted, in order; hidden files are not.
std::vector<std::string> filesIn(const std::filesystem::path& folder,
                                 const std::function<bool(const std::string&)>& accepts) {
    std::vector<std::string> files;
    std::error_code failed;
    const std::filesystem::path shown = folder.empty() ? std::filesystem::path(".") : folder;
    for (const auto& entry : std::filesystem::directory_iterator(shown, failed)) {
        const std::string name = entry.path().filename().string();
        if (name.front() != '.' && accepts(name)) files.push_back((folder / name).string());
    }
    if (failed)
        throw IoError(fmt::format("{}: cannot be read: {}", shown.string(), failed.message()));
    std::sort(files.begin(), files.end(), inOrder);
    return files;
}

/// The text of a name with # for each number, and the numbers.
std::pair<std::string, std::vector<double>> partsOf(const std::string& name) {
    std::pair<std::string, std::vector<double>> parts;
    for (std::size_t i = 0; i < name.size();) {
        std::size_t end = i;
        while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
        if (end > i) parts.second.push_back(std::stod(name.substr(i, end - i)));
        parts.first.push_back(end > i ? '#' : name[i]);
        i = std::max(end, i + 1);
    }
    return parts;
}

/// Refuses files, in order, of whose numbers some are missing, and others among numbered ones.
void checkNumbers(const std::vector<std::string>& files) {
    const auto nameOf = [](const std::string& file) {
        return std::filesystem::path(file).filename().string();
    };
    std::map<std::string, std::vector<std::string>> groups;
    for (const std::string& file : files) groups[partsOf(nameOf(file)).first].push_back(file);
    if (groups.size() == files.size()) return;  // not numbered
    const auto slices = std::max_element(
        groups.begin(), groups.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    for (const auto& [text, members] : groups)
        if (text != slices->first)
            throw InputError(
                fmt::format("{}: is not named as the other slices, such as {}; take it out of the "
                            "folder, or give a pattern of names that it does not match",
                            members.front(), slices->second.front()));
    std::vector<std::vector<double>> numbers;
    for (const std::string& file : files) numbers.push_back(partsOf(nameOf(file)).second);
    std::string missing;
    for (std::size_t at = numbers.front().size(); at-- > 0;) {
        double least = std::numeric_limits<double>::infinity(), most = 0;
        std::size_t where = 1;  // the largest gap ends there
        for (std::size_t k = 1; k < files.size(); ++k) {
            const double gap = numbers[k][at] - numbers[k - 1][at];
            least = std::min(least, gap);
            if (gap > most) where = k;
            most = std::max(most, gap);
        }
        if (least > 0 && most == least) return;  // counts the slices
        if (least > 0)
            missing = fmt::format(
                "{} and {}: are {:.0f} apart, other files {:.0f}: number {:.0f} is missing; "
                "add it, or number the files without gaps if no slice is missing",
                files[where - 1], files[where], most, least, numbers[where - 1][at] + least);
    }
    if (!missing.empty()) throw InputError(missing);
}

bool isFolder(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
}

/// Slices as TIFF or DICOM, or masks.
Image readFolder(const std::string& path, const ImageReadOptions& options) {
    const auto slices = filesIn(path, isTiff), masks = filesIn(path, namesMask);
    if (!masks.empty()) {
        const auto others = slices.empty()
                                ? filesIn(path,
                                          [&](const std::string& name) {
                                              const auto file = std::filesystem::path(path) / name;
                                              return std::filesystem::is_regular_file(file) &&
                                                     checkDicom(file.string()).dicom;
                                          })
                                : slices;
        if (others.empty()) return readMasks(masks, path, options);
        throw InputError(fmt::format(
            "{}: has masks such as {} and slices such as {}; move one kind into another folder, or "
            "give the file of one mask",
            path, masks.front(), others.front()));
    }
    if (slices.empty()) return readDicom(path, options);
    checkNumbers(slices);
    return readTiffStack(slices, options);
}

bool isPattern(const std::string& path) {
    return isTiff(path) &&
           std::filesystem::path(path).filename().string().find('*') != std::string::npos;
}

bool isNifti(const std::string& path) {
    const std::string extension = extensionOf(path);
    return extension == ".nii" || extension == ".hdr" ||
           (extension == ".gz" && extensionOf(path.substr(0, path.size() - 3)) == ".nii");
}

}  // namespace

bool namesImage(const std::string& path) {
    const std::string extension = extensionOf(path);
    for (const char* other : {".nrrd", ".nhdr", ".mha", ".mhd", ".dcm"})
        if (extension == other) return true;
    if (isNifti(path) || isTiff(path)) return true;
    // A folder with the name of a mesh or a pack is a mistake.
    for (const char* other : {".stl", ".obj", ".ply", ".off", ".gts", ".vtp", ".vtk", ".vdb",
                              ".csv", ".npz", ".xyz", ".data", ".hdf", ".vtkhdf", ".pvtp"})
        if (extension == other) return false;
    return isFolder(path);
}

Image readImage(const std::string& path, const ImageReadOptions& options) {
    if (options.spacing)
        for (const double s : options.spacing->c)
            if (!(s > 0) || !std::isfinite(s))
                throw ParameterError(fmt::format(
                    "`voxelSpacing` {:g},{:g},{:g}: distances of voxels are positive",
                    (*options.spacing)[0], (*options.spacing)[1], (*options.spacing)[2]));
    if (isFolder(path)) return readFolder(path, options);
    if (isPattern(path)) {
        const std::filesystem::path pattern = path;
        const std::string wanted = pattern.filename().string();
        const auto files = filesIn(pattern.parent_path(), [&](const std::string& name) {
            return isTiff(name) && matches(name.c_str(), wanted.c_str());
        });
        if (files.empty()) throw IoError(path + ": no file has such a name");
        checkNumbers(files);
        return readTiffStack(files, options);
    }
    requireThere(path);
    const std::string extension = extensionOf(path);
    if (extension == ".mha" || extension == ".mhd") return readMetaImage(path, options);
    if (isNifti(path)) return readNifti(path, options);
    const bool byItk = isTiff(path) || extension == ".nrrd" || extension == ".nhdr";
    return byItk ? readByItk(path, options) : readDicom(path, options);
}

}  // namespace vdbpack
