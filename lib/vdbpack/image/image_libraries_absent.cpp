#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom.h"
#include "vdbpack/image/itk_image.h"
#include "vdbpack/image/nifti.h"

namespace vdbpack {

namespace {

[[noreturn]] void refuse(const std::string& path) {
    throw ParameterError(path +
                         ": this build reads no images; install libinsighttoolkit5-dev and "
                         "libnifti2-dev, and build again with GCC");
}

}  // namespace

Image readNifti(const std::string& path, const ImageReadOptions&) {
    refuse(path);
}
Image readByItk(const std::string& path, const ImageReadOptions&) {
    refuse(path);
}
Image readDicom(const std::string& path, const ImageReadOptions&) {
    refuse(path);
}
Image readTiffStack(const std::vector<std::string>& files, const ImageReadOptions&) {
    refuse(files.front());
}

}  // namespace vdbpack
