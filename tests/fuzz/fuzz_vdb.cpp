// .vdb files: packs, level sets, fields of directions and of numbers.
#include "fuzz_fields.h"
#include "fuzz_file.h"

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/pack_file.h"

using namespace vdbpack;

/// OpenVDB 10 loses a few bytes a leaf where reading a point grid ends early: the handles of its
/// pages lie in a union (points/AttributeArray.h) that no destructor looks into.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:compression::PagedInputStream::createHandle\n";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("f.vdb");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack(path)); });
    fuzz::readOrRefuse(path, [&] {
        const TriangleMesh mesh = levelSetMesh(path, "", 1);
        for (const auto& v : mesh.vertices)
            if (!isFinite(v)) fuzz::report("a vertex is not finite");
    });
    fuzz::readDirections(path);
    fuzz::readNumbers(path);
    return 0;
}
