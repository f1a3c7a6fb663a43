// Packs from .vtp files.
#include "fuzz_file.h"

#include "vdbpack/formats/pack_file.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p.vtp");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack("vtp:" + path)); });
    return 0;
}
