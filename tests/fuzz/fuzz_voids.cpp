// Lists and matrices of voids, directions and numbers as tables. All of them read every input: what
// is none of theirs must be refused.
#include "fuzz_fields.h"
#include "fuzz_file.h"

#include "vdbpack/voids/void_list.h"

using namespace vdbpack;

namespace {

template <int Dim>
void readList(const std::string& path) {
    for (const auto& e : readVoidList<Dim>(path))
        if (!isFinite(e.center) || !(e.a > 0) || !(e.b > 0) ||
            !(std::fabs(length(e.axis) - 1) < 1e-9))
            fuzz::report("a void without a size or an axis");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("v.csv");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { readList<2>(path); });
    fuzz::readOrRefuse(path, [&] { readList<3>(path); });
    fuzz::readOrRefuse(path, [&] {
        const VoidMatrix matrix = readVoidMatrix(path);
        std::size_t cells = 1;
        for (const int n : matrix.size) cells *= static_cast<std::size_t>(n);
        if (cells == 0 || cells != matrix.cells.size()) fuzz::report("a matrix without its cells");
    });
    fuzz::readDirections(path);
    fuzz::readNumbers(path);
    return 0;
}
