// The C++ part of the Python module: runs on what Python holds in memory, and packs as arrays. The
// package around it turns keyword arguments into words of the command line, so that both take the
// same options and give the same packs.
#include "cli/option_names.h"
#include "cli/options.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/field/dense_level_set.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/run_convert.h"
#include "vdbpack/run/run_image.h"
#include "vdbpack/run/run_mesh.h"
#include "vdbpack/verify/pack_hash.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

namespace py = pybind11;
using namespace vdbpack;

namespace {

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

// --- Packs as arrays

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

py::array positions(const Shared& data) {
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

py::array radii(const Shared& data) {
    return std::visit(
        [&](const auto& pack) {
            const auto n = static_cast<py::ssize_t>(pack.spheres.size());
            static const double none = 0;
            const double* first = n > 0 ? &pack.spheres[0].radius : &none;
            return view(data, first, {n}, {static_cast<py::ssize_t>(sizeof(pack.spheres[0]))});
        },
        data->pack);
}

/// All attributes and further columns by name: read-only arrays, or lists of texts.
py::dict columns(const Shared& data) {
    py::dict all;
    const auto add = [&](std::string_view name, const auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        if (values.empty()) return;
        if constexpr (std::is_same_v<Value, std::string>)
            all[py::str(std::string(name))] = py::cast(values);
        else
            all[py::str(std::string(name))] = columnView(data, values);
    };
    forEachAttribute(data->attributes(), add);
    return all;
}

/// An array of whole numbers, by value. @throws ParameterError for anything else
IndexArray wholeNumbers(const py::object& values, const std::string& name) {
    const py::array given = py::array::ensure(values);
    const DoubleArray numbers = given ? DoubleArray::ensure(given) : DoubleArray();
    if (!given || !numbers) {
        PyErr_Clear();
        throw ParameterError(name + ": an array of whole numbers is needed");
    }
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        if (const double v = numbers.data()[i]; v != std::floor(v) || std::fabs(v) > 0x1p63)
            throw ParameterError(fmt::format("{}: {} is no whole number", name, v));
    return IndexArray::ensure(given);
}

/// @param name  of the array, for messages
template <class Array>
void requireLength(const Array& array, std::size_t n, const std::string& name) {
    if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != n)
        throw ParameterError(fmt::format(
            "{}: has {} dimensions and {} values; one value for each of {} spheres is needed", name,
            array.ndim(), array.size(), n));
}

void takeColumn(const std::string& name, const py::object& values, std::size_t n,
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

Shared packOf(const DoubleArray& centers, const DoubleArray& radius, const py::dict& further,
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
Pack<3> inSpace(const PackData& data) {
    if (const auto* pack = std::get_if<Pack<3>>(&data.pack)) return *pack;
    const auto& flat = std::get<Pack<2>>(data.pack);
    Pack<3> pack;
    static_cast<PackAttributes&>(pack) = flat;
    for (const Sphere<2>& s : flat.spheres)
        pack.spheres.push_back({{{s.center[0], s.center[1], flat.sliceHeight}}, s.radius});
    return pack;
}

// --- Runs that Python can interrupt

/// Works on another thread, while this one listens to signals and tells progress.
class Attended {
public:
    /// @param progress  called with a stage, its share that is done and a count; or None
    explicit Attended(py::object progress) : progress_(std::move(progress)) {
        const py::module_ threading = py::module_::import("threading");
        hearsSignals_ = threading.attr("current_thread")().is(threading.attr("main_thread")());
    }

    /// What `work(callbacks)` returns. @throws what it does; what Python raised meanwhile
    template <class Work>
    auto run(const Work& work) {
        std::optional<std::decay_t<decltype(work(Callbacks{}))>> result;
        std::exception_ptr failure;
        std::unique_ptr<py::error_already_set> raised;
        {
            const py::gil_scoped_release released;
            {
                const Listed listed(*this);
                Joining worker;  // however this ends
                worker.onEnd = [this] { cancelled_ = true; };
                worker.thread = std::thread([&] {
                    try {
                        result.emplace(work(callbacks()));
                    } catch (...) {
                        failure = std::current_exception();
                    }
                    const std::lock_guard<std::mutex> lock(mutex_);
                    done_ = true;
                    news_.notify_one();
                });
                while (!attend(raised)) {
                }
                worker.onEnd = nullptr;
            }
            if (!hearsSignals_) stayWhilePythonEnds();
        }
        if (raised) throw py::error_already_set(std::move(*raised));
        if (failure) std::rethrow_exception(failure);
        return std::move(*result);
    }

    /// Ends all runs, when Python exits: their threads must not outlive what they use.
    static void stopAll() {
        const py::gil_scoped_release released;
        std::unique_lock<std::mutex> lock(listMutex());
        // A run of the main thread, which calls this, has ended.
        isLeaving() = true;
        for (Attended* run : list()) run->cancelled_ = true;
        constexpr auto kPatience = std::chrono::seconds(10);
        listEmpty().wait_for(lock, kPatience, [] { return list().empty(); });
    }

private:
    // What runs just now, for `stopAll` alone.
    static std::set<Attended*>& list() {
        static std::set<Attended*> runs;
        return runs;
    }
    static std::mutex& listMutex() {
        static std::mutex mutex;
        return mutex;
    }
    static std::condition_variable& listEmpty() {
        static std::condition_variable empty;
        return empty;
    }
    struct Listed {
        explicit Listed(Attended& run) : run_(run) {
            const std::lock_guard<std::mutex> lock(listMutex());
            list().insert(&run_);
        }
        ~Listed() {
            const std::lock_guard<std::mutex> lock(listMutex());
            list().erase(&run_);
            listEmpty().notify_all();
        }
        Listed(const Listed&) = delete;
        Listed& operator=(const Listed&) = delete;

    private:
        Attended& run_;
    };

    struct Joining {
        std::function<void()> onEnd;
        std::thread thread;
        ~Joining() {
            if (onEnd) onEnd();
            thread.join();
        }
    };

    static std::atomic<bool>& isLeaving() {
        static std::atomic<bool> leaving{false};
        return leaving;
    }

    static bool isPythonEnding() {
        if (isLeaving()) return true;
#if PY_VERSION_HEX >= 0x030d0000
        return Py_IsFinalizing() != 0;
#else
        return _Py_IsFinalizing() != 0;
#endif
    }

    /// A thread that asked for Python's lock then would be ended within a destructor.
    static void stayWhilePythonEnds() {
        while (isPythonEnding()) std::this_thread::sleep_for(std::chrono::hours(1));
    }

    Callbacks callbacks() {
        Callbacks callbacks;
        callbacks.cancelled = [this] { return cancelled_.load(); };
        callbacks.warning = [this](const std::string& text) {
            const std::lock_guard<std::mutex> lock(mutex_);
            warnings_.push_back(withOptionNames(text));
        };
        if (!progress_.is_none())
            callbacks.progress = [this](const Progress& p) {
                const std::lock_guard<std::mutex> lock(mutex_);
                latest_ = p;
            };
        return callbacks;
    }

    /// @return whether the work has ended
    bool attend(std::unique_ptr<py::error_already_set>& raised) {
        constexpr auto kOften = std::chrono::milliseconds(50);
        bool ended = false;
        std::optional<Progress> latest;
        std::vector<std::string> warnings;
        {
            std::unique_lock<std::mutex> lock(mutex_);
            ended = news_.wait_for(lock, kOften, [this] { return done_; });
            latest = std::exchange(latest_, std::nullopt);
            warnings = std::exchange(warnings_, {});
        }
        if (!hearsSignals_ && isPythonEnding()) cancelled_ = true;
        const bool hasNews = !warnings.empty() || (latest && !ended);
        if (raised || cancelled_ || !(hasNews || (hearsSignals_ && !ended))) return ended;
        const py::gil_scoped_acquire held;
        try {
            if (hearsSignals_ && !ended && PyErr_CheckSignals() != 0) throw py::error_already_set();
            for (const std::string& text : warnings)
                py::module_::import("vdbpack._errors").attr("warn")(text);
            if (latest && !ended) progress_(latest->stage, latest->fraction, latest->count);
        } catch (py::error_already_set& e) {
            raised = std::make_unique<py::error_already_set>(std::move(e));
            cancelled_ = true;
        }
        return ended;
    }

    py::object progress_;
    bool hearsSignals_ = false;  // only the main thread does
    std::mutex mutex_;
    std::condition_variable news_;
    bool done_ = false;
    std::atomic<bool> cancelled_{false};
    std::optional<Progress> latest_;
    std::vector<std::string> warnings_;
};

/// What Python holds in memory, in place of files.
struct Inputs {
    std::shared_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const Image> image;
    std::shared_ptr<const VdbGrid> levelSet, solid;
    Shared pack, existing;
    bool isTemporary = false;  // files that are gone after the run
};

std::shared_ptr<const TriangleMesh> meshOf(const py::object& vertices, const py::object& faces) {
    const DoubleArray points = DoubleArray::ensure(vertices);
    const IndexArray corners = wholeNumbers(faces, "faces");
    if (!points || points.ndim() != 2 || points.shape(1) != 3)
        throw ParameterError("vertices: an array of numbers of shape (N, 3) is needed");
    if (corners.ndim() != 2 || corners.shape(1) != 3)
        throw ParameterError("faces: an array of whole numbers of shape (M, 3) is needed");
    auto mesh = std::make_shared<TriangleMesh>();
    const auto n = points.shape(0);
    if (n > std::numeric_limits<std::uint32_t>::max())
        throw ParameterError("vertices: at most 2^32 can be taken");
    for (py::ssize_t i = 0; i < n; ++i) {
        mesh->vertices.push_back({{points.at(i, 0), points.at(i, 1), points.at(i, 2)}});
        for (const double c : mesh->vertices.back().c)
            if (!std::isfinite(c))
                throw InputError(fmt::format("vertices: row {} is not finite", i));
    }
    for (py::ssize_t t = 0; t < corners.shape(0); ++t) {
        std::array<std::uint32_t, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t v = corners.at(t, static_cast<py::ssize_t>(k));
            if (v < 0 || v >= n)
                throw InputError(
                    fmt::format("faces: row {} names vertex {}, and there are {}", t, v, n));
            triangle[k] = static_cast<std::uint32_t>(v);
        }
        mesh->triangles.push_back(triangle);
    }
    if (mesh->triangles.empty()) throw InputError("faces: there are none");
    return mesh;
}

/// The type of 64-bit numbers that 32 bits hold. @throws InputError for larger ones
std::int32_t fitting(const py::array& values) {
    for (const char* end : {"min", "max"}) {
        const auto extreme = values.attr(end)().cast<double>();
        if (extreme < -0x1p31 || extreme >= 0x1p31)
            throw InputError(fmt::format("image: {} does not fit into 32 bits", extreme));
    }
    return 0;
}

/// @param affine  from indices to mm, in the world of DICOM (LPS), 4 x 4
std::shared_ptr<const Image> imageOf(const py::array& values, const DoubleArray& affine) {
    if (values.ndim() != 3) throw ParameterError("image: an array of three dimensions is needed");
    if (affine.ndim() != 2 || affine.shape(0) != 4 || affine.shape(1) != 4)
        throw ParameterError("affine: a matrix of shape (4, 4) is needed");
    auto image = std::make_shared<Image>();
    for (std::size_t d = 0; d < 3; ++d) {
        const auto axis = static_cast<py::ssize_t>(d);
        image->grid.size[d] = static_cast<std::size_t>(values.shape(axis));
        if (image->grid.size[d] == 0) throw InputError("image: it has no voxels");
        for (std::size_t row = 0; row < 3; ++row)
            image->grid.step[d].c[row] = affine.at(static_cast<py::ssize_t>(row), axis);
        image->grid.origin.c[d] = affine.at(axis, 3);
    }
    if (!(std::fabs(image->grid.signedVoxelVolume()) > 0) ||
        !std::isfinite(image->grid.signedVoxelVolume()) ||
        !std::isfinite(squaredLength(image->grid.origin)))
        throw InputError("affine: its axes lie in one plane, or are not finite");
    // The first index is the fastest in memory.
    const auto take = [&](auto type, VoxelType voxels) {
        using T = decltype(type);
        const py::array_t<T, py::array::f_style | py::array::forcecast> packed(values);
        const std::size_t bytes = sizeof(T) * image->grid.voxels();
        image->type = voxels;
        image->bytes.reset(static_cast<std::byte*>(std::malloc(bytes)));
        if (!image->bytes) throw ResourceError("image: no memory for a copy of it");
        std::memcpy(image->bytes.get(), packed.data(), bytes);
    };
    const char kind = values.dtype().kind();
    const auto size = values.dtype().itemsize();
    if (kind == 'b' || (kind == 'u' && size == 1))
        take(std::uint8_t{}, VoxelType::uint8);
    else if (kind == 'u' && size == 2)
        take(std::uint16_t{}, VoxelType::uint16);
    else if (kind == 'i' && size <= 2)
        take(std::int16_t{}, VoxelType::int16);
    else if (kind == 'u' && size == 4)
        take(std::uint32_t{}, VoxelType::uint32);
    else if (kind == 'i' || kind == 'u')
        take(fitting(values), VoxelType::int32);
    else if (kind == 'f' && size == 4)
        take(float{}, VoxelType::float32);
    else if (kind == 'f')
        take(double{}, VoxelType::float64);
    else
        throw ParameterError("image: an array of numbers is needed");
    image->format = "array";
    return image;
}

std::shared_ptr<const VdbGrid> levelSetIn(const FloatArray& values, double spacing,
                                          const std::array<double, 3>& origin) {
    if (!values || values.ndim() != 3)
        throw ParameterError("level set: an array of numbers of three dimensions is needed");
    DenseLevelSet dense;
    for (std::size_t d = 0; d < 3; ++d)
        dense.size[d] = static_cast<std::size_t>(values.shape(static_cast<py::ssize_t>(d)));
    dense.spacing = spacing;
    dense.origin = {origin};
    if (!std::isfinite(squaredLength(dense.origin)))
        throw ParameterError("origin: its coordinates must be finite");
    dense.values.assign(values.data(), values.data() + values.size());
    return levelSetOf(dense, "surface");
}

Inputs inputsOf(const py::dict& given) {
    Inputs inputs;
    inputs.isTemporary = given.contains("temporary");
    const auto find = [&](const char* name) -> py::object {
        return given.contains(name) ? py::object(given[name]) : py::none();
    };
    if (const py::object mesh = find("mesh"); !mesh.is_none())
        inputs.mesh = meshOf(mesh[py::int_(0)], mesh[py::int_(1)]);
    if (const py::object image = find("image"); !image.is_none()) {
        const py::array values = py::array::ensure(image[py::int_(0)]);
        const DoubleArray affine = DoubleArray::ensure(image[py::int_(1)]);
        if (!values || !affine) throw ParameterError("image: arrays of numbers are needed");
        inputs.image = imageOf(values, affine);
    }
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
    if constexpr (std::is_base_of_v<MeasureRecipe, Recipe>) recipe.solid = inputs.solid;
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
    if (job.dryRun) throw ParameterError("dry_run: start vdb_pack for a prediction");
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
    const MeshResult result = runMesh(job, callbacks);
    Outcome outcome = tableOf(result);
    outcome.passed = result.passed;
    outcome.failures = failures(result);
    return outcome;
}
Outcome perform(const ImageRecipe& job, const Callbacks& callbacks) {
    return tableOf(runImage(job, callbacks));
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

/// One command: its words, and what they do not say. @return a dict for the package
py::dict runCommand(const std::vector<std::string>& words, const py::dict& given,
                    const py::object& progress) {
    Job job = jobOf(words);
    const Inputs inputs = inputsOf(given);
    std::visit([&](auto& recipe) { give(inputs, recipe); }, job);
    Outcome outcome = Attended(progress).run([&](const Callbacks& callbacks) {
        return std::visit([&](const auto& recipe) { return perform(recipe, callbacks); }, job);
    });
    py::dict result;
    result["report"] = outcome.report;
    result["summary"] = withOptionNames(outcome.summary);
    result["failures"] = withOptionNames(outcome.failures);
    result["passed"] = outcome.passed;
    result["picture"] = py::bytes(outcome.picture);
    result["voids"] = std::visit([](const auto& voids) { return arraysOf(voids); }, outcome.voids);
    py::dict sets;
    for (const auto& grid : outcome.levelSets)
        sets[py::str(levelSetName(*grid))] = py::cast(LevelSetData{grid});
    result["level_sets"] = sets;
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

/// Errors of the library as those of the package.
void translate(std::exception_ptr failure) {
    const auto raise = [](const char* name, const std::string& text) {
        const py::module_ errors = py::module_::import("vdbpack._errors");
        PyErr_SetObject(errors.attr(name).ptr(),
                        py::object(errors.attr("named")(withOptionNames(text))).ptr());
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
    m.def("run", &runCommand, py::arg("words"), py::arg("inputs"), py::arg("progress"));
    m.def("read", &readFile, py::arg("file"), py::arg("unit"), py::arg("grid"));
    m.def("write", &writeFile, py::arg("pack"), py::arg("file"), py::arg("unit"));
}
