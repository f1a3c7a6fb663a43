#include "catalog.h"

#include "bones.h"
#include "irregular.h"

namespace vdbpack {

const std::vector<Asset>& assets() {
    static const std::vector<Asset> all{
        {"femur", "right femur, sculpted; mm, +x left +y back +z up", femur, 1.6, 2},
        {"mandible", "mandible, sculpted; mm, +x left +y back +z up", mandible, 1.0, 2},
        {"hip", "right hip bone, sculpted; mm, +x left +y back +z up", hip, 1.5, 0},
        {"skull", "cranium, sculpted; mm, +x left +y back +z up", skull, 1.9, -10},
        {"irregular", "lumpy body, sculpted; mm", irregular, 2.15, 2},
    };
    return all;
}

}  // namespace vdbpack
