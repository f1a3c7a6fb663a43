// Packs from files of the format VDBPACK_FUZZ_FORMAT, such as "csv".
#include "fuzz_file.h"

#include "vdbpack/formats/pack_file.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p." VDBPACK_FUZZ_FORMAT);
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack(VDBPACK_FUZZ_FORMAT ":" + path)); });
    return 0;
}
