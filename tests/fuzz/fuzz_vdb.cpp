// .vdb files: packs, level sets and fields of directions.
#include "fuzz_file.h"

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/export/pack_file.h"
#include "vdbpack/voids/direction_field.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("f.vdb");
    const std::string& path = file.write(data, size);
    fuzz::readOrRefuse(path, [&] { fuzz::requireSound(readPack(path)); });
    fuzz::readOrRefuse(path, [&] {
        const TriangleMesh mesh = levelSetMesh(path, "", 1);
        for (const auto& v : mesh.vertices)
            if (!isFinite(v)) fuzz::report("a vertex is not finite");
    });
    fuzz::readOrRefuse(path, [&] {
        const auto field = readDirectionField(path);
        for (const Vec<3>& x : {Vec<3>{}, Vec<3>{{1, 2, 3}}, Vec<3>{{-1e9, 1e9, 0.5}}})
            if (!(std::fabs(length(field->at(x)) - 1) < 1e-9))
                fuzz::report("a direction whose length is not one");
    });
    return 0;
}
