// Arrays of numpy as the library takes them.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/options/jobs.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace vdbpack {

namespace py = pybind11;

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// A text of a file, whatever bytes it has.
inline py::str textOf(const std::string& bytes) {
    return py::reinterpret_steal<py::str>(
        PyUnicode_DecodeUTF8(bytes.data(), static_cast<py::ssize_t>(bytes.size()), "replace"));
}

/// The style of Python for options: "target_count".
inline std::string keywordName(const std::string& option) {
    std::string name = option;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

/// A text of the library that names keyword arguments.
inline py::str shownText(const std::string& text) {
    return textOf(withOptionNames(text, keywordName));
}

/// An array of whole numbers, by value. @throws ParameterError for anything else
inline IndexArray wholeNumbers(const py::object& values, const std::string& name) {
    const py::array given = py::array::ensure(values);
    const DoubleArray numbers = given ? DoubleArray::ensure(given) : DoubleArray();
    if (!given || !numbers) {
        PyErr_Clear();
        throw ParameterError(name + ": an array of whole numbers is needed");
    }
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        if (const double v = numbers.data()[i]; v != std::floor(v) || !(std::fabs(v) < 0x1p63))
            throw ParameterError(fmt::format("{}: {} is no whole number", name, v));
    return IndexArray::ensure(given);
}

}  // namespace vdbpack
