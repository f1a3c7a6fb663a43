// Packs from the text files of DEM programs, told apart as they begin.
#include "fuzz_file.h"

#include "vdbpack/formats/pack_file.h"

#include <string_view>

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("p.txt");
    const std::string& path = file.write(data, size);
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const char first = text.empty() ? '#' : text.front();
    const auto begins = [text](std::string_view word) {
        return text.substr(0, word.size()) == word;
    };
    const std::string format = begins("Version")                               ? "dat:"
                               : begins("Mercury")                             ? "restart:"
                               : begins("LSM")                                 ? "geo:"
                               : first == 'I'                                  ? "dump:"
                               : (first >= 'A' && first <= 'Z') || first < '!' ? "lammps:"
                                                                               : "yade:";
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack(format + path)); });
    return 0;
}
