// Packs from .csv files.
#include "fuzz_file.h"

#include "vdbpack/formats/pack_file.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p.csv");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack("csv:" + path)); });
    return 0;
}
