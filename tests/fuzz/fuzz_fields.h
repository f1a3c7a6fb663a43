// Fields of directions and of numbers, which come as tables and in .vdb files.
#pragma once

#include "fuzz_file.h"

#include "vdbpack/voids/direction_field.h"
#include "vdbpack/voids/scalar_field.h"

#include <array>

namespace vdbpack::fuzz {

inline const std::array<Vec<3>, 3> kFieldPoints{{{}, {{1, 2, 3}}, {{-1e9, 1e9, 0.5}}}};

/// Reads a field of directions, or is refused; it must point somewhere wherever it is asked.
inline void readDirections(const std::string& path) {
    readOrRefuse(path, [&] {
        const auto field = readDirectionField(path);
        for (const auto& x : kFieldPoints)
            if (!(std::fabs(length(field->at(x)) - 1) < 1e-9))
                report("a direction whose length is not one");
    });
}

/// Reads a field of numbers, or is refused; it must stay within its values wherever it is asked.
inline void readNumbers(const std::string& path) {
    const ScalarMeaning meaning{"BV/TV", {"bvtv", "value"}, [](double) { return std::string(); }};
    readOrRefuse(path, [&] {
        const auto field = readScalarField(path, meaning);
        for (const auto& x : kFieldPoints) {
            const double value = field->at(x);
            if (!(value >= field->least()) || !(value <= field->most()))
                report("a value beyond those of the field");
        }
    });
}

}  // namespace vdbpack::fuzz
