#include "vdbpack/view/view.h"

#include "vdbpack/report/markup.h"
#include "vdbpack/view/view_data.h"

#include <fmt/format.h>

namespace vdbpack {

// Of view_texts.cpp, which CMake makes.
extern const char* const kViewStyle;
extern const char* const kViewMarkup;
extern const char* const kViewScript;

namespace {

/// JSON without characters that mean something in HTML or XML.
std::string plainJson(const nlohmann::ordered_json& json) {
    std::string out;
    for (const char c :
         json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
        if (c == '<' || c == '>' || c == '&')
            out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else
            out += c;
    }
    return out;
}

}  // namespace

template <int Dim>
ViewMarkup viewOf(const ViewScene<Dim>& scene, const ViewOptions& options) {
    const std::string classes = std::string(Dim == 3 ? "in-space" : "in-plane") +
                                (scene.pack ? "" : " of-solids") +
                                (options.large ? " view-large" : "");
    return {kViewStyle, fmt::format(fmt::runtime(kViewMarkup), fmt::arg("classes", classes),
                                    fmt::arg("label", !scene.pack ? "Solids that can be turned"
                                                      : Dim == 3  ? "Spheres that can be turned"
                                                                  : "Circles that can be moved"),
                                    fmt::arg("facts", plainJson(viewData(scene, options))),
                                    fmt::arg("script", kViewScript))};
}

template ViewMarkup viewOf<2>(const ViewScene<2>&, const ViewOptions&);
template ViewMarkup viewOf<3>(const ViewScene<3>&, const ViewOptions&);

}  // namespace vdbpack
