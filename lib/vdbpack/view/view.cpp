#include "vdbpack/view/view.h"

#include "vdbpack/report/markup.h"
#include "vdbpack/view/view_data.h"
#include "vdbpack/view/view_texts.h"

#include <fmt/format.h>

namespace vdbpack {

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

/// What the mouse, fingers and keys do; the script fills in the rest.
const char* const kSpaceControls =
    "<label class='view-cut'>cut <select class='view-axis'><option value=''>none</option>"
    "<option>x</option><option>y</option><option>z</option>"
    "<option value='view'>from the front</option></select></label>\n"
    "<label class='view-where'><input class='view-at' type='range' min='0' max='1000' value='500' "
    "aria-label='position of the cut'/><output class='view-position'></output></label>\n"
    "<label class='view-flip'><input class='view-other' type='checkbox'/> other side</label>\n";
const char* const kSpaceHelp =
    "Drag to turn, with Shift, the right button or two fingers to move, turn the wheel or pinch to "
    "zoom (on a page that scrolls, click first), click a sphere for its row. Keys: arrows turn, "
    "with Shift move; + and - zoom; x, y, z, v cut, again to stop; [ and ] move the cut; o keeps "
    "the other side; c changes the color; w shows or hides the wall; r shows all; p saves a "
    "picture; Esc ends the selection.";
const char* const kPlaneHelp =
    "Drag to move, turn the wheel or pinch to zoom (on a page that scrolls, click first), click a "
    "circle for its row. Keys: arrows move; + and - zoom; c changes the color; w shows or hides "
    "the wall; r shows all; p saves a picture; Esc ends the selection.";

}  // namespace

template <int Dim>
ViewMarkup viewOf(const ViewScene<Dim>& scene, const ViewOptions& options) {
    const ViewData data = viewData(scene, options);
    ViewMarkup view;
    view.style = kViewStyle;
    view.body = fmt::format(
        "<div class='view{}' hidden='hidden'>\n"
        "<div class='view-stage'><canvas tabindex='0' aria-label='{}'></canvas>"
        "<div class='view-scale'><i></i><span></span></div>"
        "<div class='view-row' role='status'></div></div>\n"
        "<div class='view-bar'>\n"
        "<label>color <select class='view-color'></select></label>\n"
        "<span class='view-legend'></span>\n{}"
        "<label class='view-wall'><input type='checkbox' checked='checked'/> wall</label>\n"
        "<button type='button' class='view-all'>show all</button>\n"
        "<button type='button' class='view-save'>save picture</button>\n</div>\n"
        "<p class='words view-words'></p>\n"
        "<details><summary>Mouse, fingers and keys</summary><p class='words'>{}</p></details>\n"
        "</div>\n",
        options.large ? " view-large" : "",
        Dim == 3 ? "Spheres that can be turned" : "Circles that can be moved",
        Dim == 3 ? kSpaceControls : "", escaped(Dim == 3 ? kSpaceHelp : kPlaneHelp));
    view.body += "<script type='application/json' class='view-facts'>" + plainJson(data.facts) +
                 "</script>\n<script type='text/plain' class='view-bytes'>" + base64(data.bytes) +
                 "</script>\n<script>\n//<![CDATA[\n";
    for (const char* const part : kViewScripts) view.body += part;
    view.body += "//]]>\n</script>\n";
    return view;
}

template ViewMarkup viewOf<2>(const ViewScene<2>&, const ViewOptions&);
template ViewMarkup viewOf<3>(const ViewScene<3>&, const ViewOptions&);

}  // namespace vdbpack
