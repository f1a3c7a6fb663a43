// The C++ part of the Python module: runs on what Python holds in memory, and packs as arrays. The
// package around it turns keyword arguments into words of the command line, so that both take the
// same options and give the same packs.
#include "attended.h"
#include "domain_arrays.h"
#include "pack_arrays.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/version.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/options/command_line.h"
#include "vdbpack/options/option_rows.h"
#include "vdbpack/report/image_result.h"
#include "vdbpack/run/run.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

using namespace vdbpack;

namespace {

/// Gives a recipe what Python holds in memory, in place of files.
template <class Recipe>
void give(const py::dict& inputs, Recipe& recipe) {
    const auto take = [&](const char* name, auto& field, auto make) {
        if (inputs.contains(name)) field = make(inputs[name]);
    };
    const auto packIn = [](const py::object& pack) {
        return std::make_shared<const Pack<3>>(inSpace(*pack.cast<Shared>()));
    };
    take("mesh", recipe.domain.mesh, meshOf);
    take("image", recipe.domain.image, imageOf);
    take("level_set", recipe.domain.levelSet, levelSetIn);
    if constexpr (std::is_base_of_v<InputPack, Recipe>) take("pack", recipe.given, packIn);
    if constexpr (std::is_base_of_v<MeasureRecipe, Recipe>) {
        take("solid", recipe.solid, levelSetIn);
        take("solid_mesh", recipe.solidMesh, meshOf);
        take("solid_image", recipe.solidImage, imageOf);
    }
    if constexpr (std::is_base_of_v<PackRecipe, Recipe>)
        take("existing", recipe.givenExisting, packIn);
    // A recipe with arrays, or with files that are gone after the run, cannot be repeated.
    if (!inputs.empty()) recipe.optionsText.clear();
}

/// What a run returns, before Python's lock is taken again.
struct Outcome {
    Shared pack;
    std::variant<std::vector<Ellipsoid<3>>, std::vector<Ellipsoid<2>>> voids;
    std::vector<std::shared_ptr<const VdbGrid>> levelSets;
    std::optional<TriangleMesh> mesh;
    std::string report, summary, failures, picture;
    bool passed = true;
};

template <class Result>
Outcome tableOf(const Result& result) {
    Outcome outcome;
    outcome.report = toJson(result).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    outcome.summary = summary(result);
    return outcome;
}

Outcome outcomeOf(RunResult&& run, bool hasPack) {
    Outcome outcome = tableOf(run);
    outcome.failures = failures(run);
    outcome.passed = run.passed;
    outcome.voids = std::move(run.voids);
    outcome.levelSets = std::move(run.levelSets);
    outcome.picture = std::move(run.picture.png);
    if (hasPack) outcome.pack = std::make_shared<PackData>(PackData{std::move(run.pack)});
    return outcome;
}

void requireOne(const Study& study) {
    if (!study.isOne())
        throw ParameterError("one run at a time; loop over the seeds and values of a study");
}

/// Each command.
struct Perform {
    const Callbacks& callbacks;

    Outcome operator()(const PackJob& job) const {
        if (job.dryRun) return tableOf(dryRunPack(job, callbacks));
        requireOne(job.study);
        return outcomeOf(
            runPack(recipeForSeed<PackRecipe>(job, job.study.seeds.front()), callbacks), true);
    }
    Outcome operator()(const VoidsJob& job) const {
        requireOne(job.study);
        return outcomeOf(
            runVoids(recipeForSeed<VoidsRecipe>(job, job.study.seeds.front()), callbacks), false);
    }
    Outcome operator()(const CarveRecipe& job) const {
        return outcomeOf(runCarve(job, callbacks), true);
    }
    Outcome operator()(const DensifyRecipe& job) const {
        return outcomeOf(runDensify(job, callbacks), true);
    }
    Outcome operator()(const VerifyRecipe& job) const {
        return outcomeOf(runVerify(job, callbacks), false);
    }
    Outcome operator()(const MeshRecipe& job) const {
        MeshResult result = runMesh(job, callbacks);
        Outcome outcome = tableOf(result);
        outcome.passed = result.passed;
        outcome.failures = failures(result);
        outcome.mesh = std::move(result.mesh);
        return outcome;
    }
    Outcome operator()(const MeasureRecipe& job) const {
        return tableOf(runMeasure(job, callbacks));
    }
    Outcome operator()(const StiffnessRecipe& job) const {
        return tableOf(runStiffness(job, callbacks));
    }
    Outcome operator()(const ConvertRecipe& job) const {
        return tableOf(runConvert(job, callbacks));
    }
    Outcome operator()(const ImageRecipe& job) const { return tableOf(runImage(job, callbacks)); }
    Outcome operator()(const ViewJob& job) const { return tableOf(runView(job, callbacks)); }
};

/// A level set that Python may ask for as an array.
struct LevelSetData {
    std::shared_ptr<const VdbGrid> grid;
};

/// Centers (M, Dim), half-axes a and b (M, 2), and unit vectors along a (M, Dim).
template <int Dim>
py::tuple arraysOf(const std::vector<Ellipsoid<Dim>>& voids) {
    const auto n = static_cast<py::ssize_t>(voids.size());
    DoubleArray centers({n, py::ssize_t{Dim}}), axes({n, py::ssize_t{Dim}});
    DoubleArray halves({n, py::ssize_t{2}});
    for (py::ssize_t i = 0; i < n; ++i) {
        const Ellipsoid<Dim>& e = voids[static_cast<std::size_t>(i)];
        for (int d = 0; d < Dim; ++d) {
            centers.mutable_at(i, d) = e.center[d];
            axes.mutable_at(i, d) = e.axis[d];
        }
        halves.mutable_at(i, 0) = e.a;
        halves.mutable_at(i, 1) = e.b;
    }
    return py::make_tuple(centers, halves, axes);
}

/// Vertices (N, 3) and faces (M, 3).
py::tuple arraysOf(const TriangleMesh& mesh) {
    DoubleArray vertices({static_cast<py::ssize_t>(mesh.vertices.size()), py::ssize_t{3}});
    IndexArray faces({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t{3}});
    double* coordinate = vertices.mutable_data();
    for (const Vec<3>& v : mesh.vertices)
        coordinate = std::copy(v.c.begin(), v.c.end(), coordinate);
    std::int64_t* corner = faces.mutable_data();
    for (const auto& t : mesh.triangles) corner = std::copy(t.begin(), t.end(), corner);
    return py::make_tuple(vertices, faces);
}

/// A level set as (values of shape (X, Y, Z), spacing, origin).
py::tuple arrayOf(const VdbGrid& grid) {
    const DenseLevelSet dense = denseLevelSet(grid);
    const auto& n = dense.size;
    py::array values(
        py::dtype::of<float>(),
        std::vector<py::ssize_t>{static_cast<py::ssize_t>(n[0]), static_cast<py::ssize_t>(n[1]),
                                 static_cast<py::ssize_t>(n[2])},
        dense.values.data());  // a copy
    return py::make_tuple(values, dense.spacing, dense.origin.c);
}

/// The type of a value of an option in the stub, where `Path`, `Radius` and `Numbers` are types of
/// the package.
std::string typeOf(const Option& option) {
    static const std::map<OptionKind, const char*> types{
        {OptionKind::flag, "bool"},    {OptionKind::text, "str"},
        {OptionKind::number, "float"}, {OptionKind::length, "float"},
        {OptionKind::count, "int"},    {OptionKind::numbers, "Numbers"}};
    if (option.kind == OptionKind::choice)
        return fmt::format("Literal['{}']", fmt::join(option.words, "', '"));
    if (option.file == FileIn::sizes) return "Radius";
    return option.file == FileIn::none || option.file == FileIn::voids ? types.at(option.kind)
                                                                       : "Path";
}

/// The name of each command, what it does, and its options.
std::vector<std::tuple<std::string, std::string, std::vector<Option>>> optionTable() {
    std::vector<std::tuple<std::string, std::string, std::vector<Option>>> table;
    PrintOptions print;
    for (CommandText command : commandTexts())
        table.emplace_back(command.name, command.help, optionsOf(command.job, print));
    return table;
}

/// One command: its words, and what words do not say.
/// @param words    the command and its arguments.
/// @param options  by their keywords, without a value: flags.
/// @param unset    keywords of options that it must know and that are not set.
/// @return a dict for the package
py::dict runCommand(std::vector<std::string> words,
                    const std::vector<std::pair<std::string, std::optional<std::string>>>& options,
                    std::vector<std::string> unset, const py::dict& inputs,
                    const py::object& progress) {
    const auto named = [](std::string keyword) {
        std::replace(keyword.begin(), keyword.end(), '_', '-');
        return keyword;
    };
    for (const auto& [keyword, value] : options) {
        words.push_back(optionName(named(keyword)));
        if (value) words.push_back(*value);
    }
    std::transform(unset.begin(), unset.end(), unset.begin(), named);
    const auto job = std::make_shared<Job>(jobOf(words, unset, keywordName));
    std::visit([&](auto& recipe) { give(inputs, recipe); }, *job);
    Outcome outcome = Attended(progress).run(
        [job](const Callbacks& callbacks) { return std::visit(Perform{callbacks}, *job); });
    py::dict result;
    result["report"] = outcome.report;
    result["summary"] = shownText(outcome.summary);
    result["failures"] = shownText(outcome.failures);
    result["passed"] = outcome.passed;
    result["picture"] = py::bytes(outcome.picture);
    result["voids"] = std::visit([](const auto& voids) { return arraysOf(voids); }, outcome.voids);
    py::dict sets;
    for (const auto& grid : outcome.levelSets)
        sets[py::str(levelSetName(*grid))] = py::cast(LevelSetData{grid});
    result["level_sets"] = sets;
    result["mesh"] = outcome.mesh ? py::object(arraysOf(*outcome.mesh)) : py::none();
    result["pack"] = outcome.pack;
    return result;
}

Shared readFile(const std::string& file, const std::string& unit, const std::string& grid,
                const std::string& columns, double radius) {
    PackReadOptions options;
    options.unit = parseUnit(unit);
    options.gridName = grid;
    if (!columns.empty()) options.columns = parsePackColumns(columns);
    options.radius = radius;
    auto data = std::make_shared<PackData>();
    const py::gil_scoped_release released;
    data->pack = readPack(file, options);
    return data;
}

void writeFile(const Shared& data, const std::string& file, const std::string& unit) {
    if (OutputTarget(file).kind != OutputKind::pack)
        throw ParameterError("file " + file + ": is no pack; give it to `convert` as output");
    PackWriteOptions options;
    options.unit = parseUnit(unit);
    const py::gil_scoped_release released;
    std::visit(
        [&](const auto& pack) {
            options.generator = generatorWith(std::string("vdb_pack ") + version(), pack.origin);
            writePack(pack, file, options);
        },
        data->pack);
}

/// Pairs in contact: their indices, (M, 2), and their gaps, mm.
py::tuple pairs(const Shared& data, double tolerance) {
    std::vector<Contact> found;
    {
        const py::gil_scoped_release released;
        found = std::visit(
            [&](const auto& pack) { return listContacts(pack.spheres, tolerance, pack.cell); },
            data->pack);
    }
    const auto n = static_cast<py::ssize_t>(found.size());
    py::array_t<std::int64_t> indices({n, py::ssize_t{2}});
    py::array_t<double> gaps(n);
    std::int64_t* index = indices.mutable_data();
    double* gap = gaps.mutable_data();
    for (const Contact& c : found) {
        *index++ = c.i;
        *index++ = c.j;
        *gap++ = c.gap;
    }
    return py::make_tuple(indices, gaps);
}

/// Errors of the library as those of the package.
void translate(std::exception_ptr failure) {
    const auto raise = [](const char* name, const std::string& text) {
        const py::module_ errors = py::module_::import("vdbpack._errors");
        PyErr_SetObject(errors.attr(name).ptr(), shownText(text).ptr());
    };
    try {
        if (failure) std::rethrow_exception(failure);
    } catch (const ParameterError& e) {
        raise("ParameterError", e.what());
    } catch (const InputError& e) {
        raise("InputError", e.what());
    } catch (const IoError& e) {
        raise("FileError", e.what());
    } catch (const Interrupted&) {
        PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const std::exception& e) {
        if (!isShortage(e)) throw;
        raise("ResourceError", e.what());
    }
}

}  // namespace

PYBIND11_MODULE(_core, m) {
    m.doc() = "The C++ part of vdbpack; use the package around it.";
    m.attr("__version__") = VDBPACK_VERSION;
    py::register_local_exception_translator(translate);
    py::class_<LevelSetData>(m, "LevelSetData").def("array", [](const LevelSetData& data) {
        return arrayOf(*data.grid);
    });
    py::class_<PackData, Shared>(m, "PackData")
        .def(py::init(&packOf), py::arg("positions"), py::arg("radii"), py::arg("columns"),
             py::arg("slice_height") = 0.0)
        .def_property_readonly("positions", &positions)
        .def_property_readonly("radii", &radii)
        .def_property_readonly("columns", &columns)
        .def_property(
            "part_names", [](const Shared& data) { return listOf(partNames(data->attributes())); },
            [](const Shared& data, std::vector<std::string> names) {
                std::visit([&](auto& pack) { setPartNames(pack, std::move(names)); }, data->pack);
            })
        .def("pairs", &pairs, py::arg("tolerance"))
        .def_property_readonly(
            "hash",
            [](const Shared& data) {
                return hashText(
                    std::visit([](const auto& pack) { return packHash(pack); }, data->pack));
            })
        .def_property_readonly("slice_height", [](const Shared& data) {
            const auto* flat = std::get_if<Pack<2>>(&data->pack);
            return flat ? py::object(py::float_(flat->sliceHeight)) : py::object(py::none());
        });
    py::module_::import("atexit").attr("register")(py::cpp_function(&Attended::stopAll));
    py::class_<Option>(m, "Option")
        .def_readonly("name", &Option::name)
        .def_property_readonly("keyword", [](const Option& o) { return keywordName(o.name); })
        .def_property_readonly("type", &typeOf)
        .def_property_readonly("is_length",
                               [](const Option& o) { return o.kind == OptionKind::length; })
        .def_readonly("shown", &Option::shown)
        .def_readonly("group", &Option::group)
        .def_readonly("help", &Option::help)
        .def_readonly("letter", &Option::letter)
        .def_readonly("repeats", &Option::repeats);
    m.def("options", &optionTable);
    m.def("run", &runCommand, py::arg("words"), py::arg("options"), py::arg("unset"),
          py::arg("inputs"), py::arg("progress"));
    m.def("read", &readFile, py::arg("file"), py::arg("unit"), py::arg("grid"), py::arg("columns"),
          py::arg("radius"));
    m.def("write", &writeFile, py::arg("pack"), py::arg("file"), py::arg("unit"));
}
