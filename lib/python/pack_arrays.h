// Packs as arrays of numpy, and from them.
#pragma once

#include "arrays.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/pack.h"

#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace vdbpack {

/// A pack that arrays share. Immutable once Python has it.
struct PackData {
    std::variant<Pack<3>, Pack<2>> pack;

    const PackAttributes& attributes() const {
        return std::visit([](const auto& p) -> const PackAttributes& { return p; }, pack);
    }
};
using Shared = std::shared_ptr<PackData>;

/// Values of a pack as an array without a copy, which nobody can write to.
template <class T>
py::array view(const Shared& owner, const T* first, std::vector<py::ssize_t> shape,
               std::vector<py::ssize_t> strides) {
    py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), first,
                    py::cast(owner));
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

template <class T>
py::object columnView(const Shared& owner, const std::vector<T>& values) {
    if (values.empty()) return py::none();
    return view(owner, values.data(), {static_cast<py::ssize_t>(values.size())}, {sizeof(T)});
}

inline py::array positions(const Shared& data) {
    return std::visit(
        [&](const auto& pack) {
            const auto n = static_cast<py::ssize_t>(pack.spheres.size());
            constexpr auto kStep = static_cast<py::ssize_t>(sizeof(pack.spheres[0]));
            const auto dim = static_cast<py::ssize_t>(
                pack.spheres.empty() ? (kStep - 8) / 8 : pack.spheres[0].center.c.size());
            static const double none = 0;
            const double* first = n > 0 ? pack.spheres[0].center.c.data() : &none;
            return view(data, first, {n, dim}, {kStep, 8});
        },
        data->pack);
}

inline py::array radii(const Shared& data) {
    return std::visit(
        [&](const auto& pack) {
            const auto n = static_cast<py::ssize_t>(pack.spheres.size());
            static const double none = 0;
            const double* first = n > 0 ? &pack.spheres[0].radius : &none;
            return view(data, first, {n}, {static_cast<py::ssize_t>(sizeof(pack.spheres[0]))});
        },
        data->pack);
}

inline py::list listOf(const std::vector<std::string>& texts) {
    py::list list;
    for (const std::string& text : texts) list.append(textOf(text));
    return list;
}

/// All attributes and further columns by name: read-only arrays, or lists of texts.
inline py::dict columns(const Shared& data) {
    py::dict all;
    const auto add = [&](std::string_view name, const auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        if (values.empty()) return;
        if constexpr (std::is_same_v<Value, std::string>)
            all[textOf(std::string(name))] = listOf(values);
        else
            all[textOf(std::string(name))] = columnView(data, values);
    };
    forEachAttribute(data->attributes(), add);
    return all;
}

/// @param name  of the array, for messages
template <class Array>
void requireLength(const Array& array, std::size_t n, const std::string& name) {
    if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != n)
        throw ParameterError(fmt::format(
            "{}: has {} dimensions and {} values; one value for each of {} spheres is needed", name,
            array.ndim(), array.size(), n));
}

inline void takeColumn(const std::string& name, const py::object& values, std::size_t n,
                       PackAttributes& pack) {
    const auto wholes = [&](auto& to) {
        using Value = typename std::decay_t<decltype(to)>::value_type;
        const IndexArray array = wholeNumbers(values, name);
        requireLength(array, n, name);
        to.clear();
        for (std::size_t i = 0; i < n; ++i) {
            const std::int64_t value = array.at(static_cast<py::ssize_t>(i));
            if (value != static_cast<Value>(value))
                throw ParameterError(fmt::format("{}: {} is too large", name, value));
            to.push_back(static_cast<Value>(value));
        }
    };
    if (name == "id") return wholes(pack.id);
    if (name == "region") return wholes(pack.region);
    if (name == "order") return wholes(pack.order);
    if (name == "contacts") return wholes(pack.contacts);
    Column column;
    column.name = name;
    const bool texts = py::isinstance<py::list>(values) && py::len(values) > 0 &&
                       py::isinstance<py::str>(values[py::int_(0)]);
    if (texts) {
        column.texts = values.cast<std::vector<std::string>>();
        if (column.texts.size() != n)
            throw ParameterError(
                fmt::format("{}: has {} texts for {} spheres", name, column.texts.size(), n));
        pack.columns.push_back(std::move(column));
        return;
    }
    const DoubleArray array = DoubleArray::ensure(values);
    if (!array) throw ParameterError(name + ": numbers or a list of texts are needed");
    requireLength(array, n, name);
    column.numbers.assign(array.data(), array.data() + n);
    if (name == "depth")
        pack.depth.assign(column.numbers.begin(), column.numbers.end());
    else
        pack.columns.push_back(std::move(column));
}

inline Shared packOf(const DoubleArray& centers, const DoubleArray& radius, const py::dict& further,
                     double sliceHeight) {
    if (centers.ndim() != 2 || (centers.shape(1) != 3 && centers.shape(1) != 2))
        throw ParameterError(
            "positions: an array of shape (N, 3), or (N, 2) for circles, is needed");
    const auto n = static_cast<std::size_t>(centers.shape(0));
    requireLength(radius, n, "radii");
    auto data = std::make_shared<PackData>();
    const auto fill = [&](auto& pack) {
        pack.spheres.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            auto& s = pack.spheres[i];
            for (std::size_t d = 0; d < s.center.c.size(); ++d)
                s.center.c[d] =
                    centers.at(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(d));
            s.radius = radius.at(static_cast<py::ssize_t>(i));
        }
        for (const auto& [name, values] : further)
            takeColumn(py::str(name), py::reinterpret_borrow<py::object>(values), n, pack);
        requireUsable(pack.spheres);
    };
    if (centers.shape(1) == 2) {
        Pack<2> flat;
        flat.sliceHeight = sliceHeight;
        data->pack = std::move(flat);
    }
    std::visit(fill, data->pack);
    return data;
}

/// A pack in space: circles lie at their height.
inline Pack<3> inSpace(const PackData& data) {
    if (const auto* pack = std::get_if<Pack<3>>(&data.pack)) return *pack;
    const auto& flat = std::get<Pack<2>>(data.pack);
    Pack<3> pack;
    static_cast<PackAttributes&>(pack) = flat;
    for (const Sphere<2>& s : flat.spheres)
        pack.spheres.push_back({{{s.center[0], s.center[1], flat.sliceHeight}}, s.radius});
    return pack;
}

}  // namespace vdbpack
