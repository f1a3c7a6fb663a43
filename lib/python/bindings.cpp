// The C++ part of the Python module: runs on what Python holds in memory, and packs as arrays. The
// package around it turns keyword arguments into words of the command line, so that both take the
// same options and give the same packs.
#include "attended.h"
#include "domain_arrays.h"
#include "pack_arrays.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/options/command_line.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"
#include "vdbpack/verify/pack_hash.h"

#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

using namespace vdbpack;

namespace {

/// What Python holds in memory, in place of files.
struct Inputs {
    std::shared_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const Image> image;
    std::shared_ptr<const VdbGrid> levelSet, solid;
    std::shared_ptr<const TriangleMesh> solidMesh;
    std::shared_ptr<const Image> solidImage;
    Shared pack, existing;
    bool isTemporary = false;  // files that are gone after the run
};

Inputs inputsOf(const py::dict& given) {
    Inputs inputs;
    inputs.isTemporary = given.contains("temporary");
    const auto find = [&](const char* name) -> py::object {
        return given.contains(name) ? py::object(given[name]) : py::none();
    };
    if (const py::object mesh = find("mesh"); !mesh.is_none())
        inputs.mesh = meshOf(mesh[py::int_(0)], mesh[py::int_(1)]);
    if (const py::object mesh = find("solid_mesh"); !mesh.is_none())
        inputs.solidMesh = meshOf(mesh[py::int_(0)], mesh[py::int_(1)]);
    const auto imageIn = [](const py::object& image) {
        const py::array values = py::array::ensure(image[py::int_(0)]);
        const DoubleArray affine = DoubleArray::ensure(image[py::int_(1)]);
        if (!values || !affine) throw ParameterError("image: arrays of numbers are needed");
        return imageOf(values, affine);
    };
    if (const py::object image = find("image"); !image.is_none()) inputs.image = imageIn(image);
    if (const py::object image = find("solid_image"); !image.is_none())
        inputs.solidImage = imageIn(image);
    if (const py::object set = find("level_set"); !set.is_none())
        inputs.levelSet =
            levelSetIn(FloatArray::ensure(set[py::int_(0)]), set[py::int_(1)].cast<double>(),
                       set[py::int_(2)].cast<std::array<double, 3>>());
    if (const py::object set = find("solid"); !set.is_none())
        inputs.solid =
            levelSetIn(FloatArray::ensure(set[py::int_(0)]), set[py::int_(1)].cast<double>(),
                       set[py::int_(2)].cast<std::array<double, 3>>());
    if (const py::object pack = find("pack"); !pack.is_none()) inputs.pack = pack.cast<Shared>();
    if (const py::object pack = find("existing"); !pack.is_none())
        inputs.existing = pack.cast<Shared>();
    return inputs;
}

template <class Recipe>
void give(const Inputs& inputs, Recipe& recipe) {
    recipe.domain.mesh = inputs.mesh;
    recipe.domain.image = inputs.image;
    recipe.domain.levelSet = inputs.levelSet;
    if constexpr (std::is_base_of_v<InputPack, Recipe>)
        if (inputs.pack) recipe.given = std::make_shared<const Pack<3>>(inSpace(*inputs.pack));
    if constexpr (std::is_base_of_v<MeasureRecipe, Recipe>) {
        recipe.solid = inputs.solid;
        recipe.solidMesh = inputs.solidMesh;
        recipe.solidImage = inputs.solidImage;
    }
    if constexpr (std::is_base_of_v<PackRecipe, Recipe>)
        if (inputs.existing)
            recipe.givenExisting = std::make_shared<const Pack<3>>(inSpace(*inputs.existing));
    // A recipe with arrays cannot be repeated from a file.
    if (inputs.mesh || inputs.image || inputs.levelSet || inputs.pack || inputs.existing)
        recipe.optionsText.clear();
}

/// What a run returns, before Python's lock is taken again.
struct Outcome {
    std::optional<std::variant<Pack<3>, Pack<2>>> pack;
    std::variant<std::vector<Ellipsoid<3>>, std::vector<Ellipsoid<2>>> voids;
    std::vector<std::shared_ptr<const VdbGrid>> levelSets;
    std::optional<TriangleMesh> mesh;
    std::string report, summary, failures, picture;
    bool passed = true;
};

Outcome outcomeOf(RunResult&& run, bool hasPack) {
    Outcome outcome;
    outcome.report = toJson(run).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    outcome.summary = summary(run);
    outcome.failures = failures(run);
    outcome.passed = run.passed;
    outcome.voids = std::move(run.voids);
    outcome.levelSets = std::move(run.levelSets);
    outcome.picture = std::move(run.picture.png);
    if (hasPack) outcome.pack = std::move(run.pack);
    return outcome;
}

template <class Result>
Outcome tableOf(const Result& result) {
    Outcome outcome;
    outcome.report = toJson(result).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    outcome.summary = summary(result);
    return outcome;
}

Outcome perform(const PackJob& job, const Callbacks& callbacks) {
    if (job.dryRun) return tableOf(dryRunPack(job, callbacks));
    if (!job.study.isOne())
        throw ParameterError("seed: one run at a time; loop over the seeds of a study");
    return outcomeOf(runPack(recipeForSeed<PackRecipe>(job, job.study.seeds.front()), callbacks),
                     true);
}
Outcome perform(const VoidsJob& job, const Callbacks& callbacks) {
    if (!job.study.isOne())
        throw ParameterError("seed: one run at a time; loop over the seeds of a study");
    return outcomeOf(runVoids(recipeForSeed<VoidsRecipe>(job, job.study.seeds.front()), callbacks),
                     false);
}
Outcome perform(const CarveRecipe& job, const Callbacks& callbacks) {
    return outcomeOf(runCarve(job, callbacks), true);
}
Outcome perform(const DensifyRecipe& job, const Callbacks& callbacks) {
    return outcomeOf(runDensify(job, callbacks), true);
}
Outcome perform(const VerifyRecipe& job, const Callbacks& callbacks) {
    return outcomeOf(runVerify(job, callbacks), false);
}
Outcome perform(const MeasureRecipe& job, const Callbacks& callbacks) {
    return tableOf(runMeasure(job, callbacks));
}
Outcome perform(const ConvertRecipe& job, const Callbacks& callbacks) {
    return tableOf(runConvert(job, callbacks));
}
Outcome perform(const MeshRecipe& job, const Callbacks& callbacks) {
    MeshResult result = runMesh(job, callbacks);
    Outcome outcome = tableOf(result);
    outcome.passed = result.passed;
    outcome.failures = failures(result);
    outcome.mesh = std::move(result.mesh);
    return outcome;
}
Outcome perform(const ImageRecipe& job, const Callbacks& callbacks) {
    return tableOf(runImage(job, callbacks));
}

Outcome perform(const ViewJob& job, const Callbacks& callbacks) {
    return tableOf(runView(job, callbacks));
}

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

/// One command: its words, options that it must know and that are not set, and what words do not
/// say. @return a dict for the package
py::dict runCommand(const std::vector<std::string>& words, const std::vector<std::string>& unset,
                    const py::dict& given, const py::object& progress) {
    const auto job = std::make_shared<Job>(jobOf(words, unset));
    const Inputs inputs = inputsOf(given);
    std::visit([&](auto& recipe) { give(inputs, recipe); }, *job);
    Outcome outcome = Attended(progress).run([job](const Callbacks& callbacks) {
        return std::visit([&](const auto& recipe) { return perform(recipe, callbacks); }, *job);
    });
    py::dict result;
    result["report"] = outcome.report;
    result["summary"] = textOf(withOptionNames(outcome.summary));
    result["failures"] = textOf(withOptionNames(outcome.failures));
    result["passed"] = outcome.passed;
    result["picture"] = py::bytes(outcome.picture);
    result["voids"] = std::visit([](const auto& voids) { return arraysOf(voids); }, outcome.voids);
    py::dict sets;
    for (const auto& grid : outcome.levelSets)
        sets[py::str(levelSetName(*grid))] = py::cast(LevelSetData{grid});
    result["level_sets"] = sets;
    result["mesh"] = outcome.mesh ? py::object(arraysOf(*outcome.mesh)) : py::none();
    result["pack"] = py::none();
    if (outcome.pack) {
        auto data = std::make_shared<PackData>();
        data->pack = std::move(*outcome.pack);
        result["pack"] = py::cast(data);
    }
    return result;
}

Shared readFile(const std::string& file, const std::string& unit, const std::string& grid) {
    PackReadOptions options;
    options.unit = parseUnit(unit);
    options.gridName = grid;
    auto data = std::make_shared<PackData>();
    const py::gil_scoped_release released;
    data->pack = readPack(file, options);
    return data;
}

void writeFile(const Shared& data, const std::string& file, const std::string& unit) {
    PackWriteOptions options;
    options.unit = parseUnit(unit);
    options.generator = "vdb_pack " VDBPACK_VERSION;
    const py::gil_scoped_release released;
    std::visit([&](const auto& pack) { writePack(pack, file, options); }, data->pack);
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
    for (py::ssize_t k = 0; k < n; ++k) {
        const Contact& c = found[static_cast<std::size_t>(k)];
        indices.mutable_at(k, 0) = c.i;
        indices.mutable_at(k, 1) = c.j;
        gaps.mutable_at(k) = c.gap;
    }
    return py::make_tuple(indices, gaps);
}

/// Errors of the library as those of the package.
void translate(std::exception_ptr failure) {
    const auto raise = [](const char* name, const std::string& text) {
        const py::module_ errors = py::module_::import("vdbpack._errors");
        PyErr_SetObject(errors.attr(name).ptr(),
                        py::object(errors.attr("named")(textOf(withOptionNames(text)))).ptr());
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
    m.def("run", &runCommand, py::arg("words"), py::arg("unset"), py::arg("inputs"),
          py::arg("progress"));
    m.def("read", &readFile, py::arg("file"), py::arg("unit"), py::arg("grid"));
    m.def("write", &writeFile, py::arg("pack"), py::arg("file"), py::arg("unit"));
}
