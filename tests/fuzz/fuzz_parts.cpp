// Parts of a pack: their options as TOML.
#include "cli/parts_file.h"
#include "fuzz_file.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p.toml");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] {
        const auto parts = readPartsFile(path);
        if (parts.empty()) fuzz::report("no part");
        for (const PartWords& part : parts)
            if (part.arguments.empty() || part.arguments.front().empty())
                fuzz::report("a part without a domain");
    });
    return 0;
}
