// Fields of directions, which come as tables and in .vdb files.
#pragma once

#include "fuzz_file.h"

#include "vdbpack/voids/direction_field.h"

namespace vdbpack::fuzz {

/// Reads a field, or is refused; it must point somewhere wherever it is asked.
inline void readDirections(const std::string& path) {
    readOrRefuse(path, [&] {
        const auto field = readDirectionField(path);
        for (const Vec<3>& x : {Vec<3>{}, Vec<3>{{1, 2, 3}}, Vec<3>{{-1e9, 1e9, 0.5}}})
            if (!(std::fabs(length(field->at(x)) - 1) < 1e-9))
                report("a direction whose length is not one");
    });
}

}  // namespace vdbpack::fuzz
