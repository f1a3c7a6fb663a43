// Parts of a pack: their options as TOML.
#include "fuzz_file.h"

#include "vdbpack/options/recipe_toml.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p.toml");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] {
        const auto parts = readPartsFile(path, [](const std::string& option) {
            return option == "domain" ? FileIn::domain : FileIn::pack;
        });
        if (parts.empty()) fuzz::report("no part");
        for (const PartWords& part : parts)
            if (part.arguments.empty() || part.arguments.front().empty())
                fuzz::report("a part without a domain");
    });
    return 0;
}
