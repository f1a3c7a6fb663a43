#include "cli/option_names.h"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace {

struct OptionName {
    std::string_view parameter, option;
};

/// Fields of the library's recipes and options. Names that several of them share are qualified.
constexpr OptionName kOptionNames[] = {
    {"cavities", "--cavities"},
    {"blockSide", "--block-side"},
    {"cell", "--void-cell"},
    {"clips", "--clip"},
    {"contactTolerance", "--contact-tol"},
    {"cull", "--cull"},
    {"deleteFraction", "--delete-fraction"},
    {"densify", "--densify"},
    {"density", "--density"},
    {"dilation", "--dilation"},
    {"domain", "--domain"},
    {"effort", "--effort"},
    {"existing", "--existing"},
    {"fill", "--fill"},
    {"gap", "--gap"},
    {"gridName", "--grid"},
    {"images", "--images"},
    {"keepConnected", "--keep-connected"},
    {"matrix", "--void-matrix"},
    {"maxCount", "--max-count"},
    {"memoryLimit", "--memory-limit"},
    {"order", "--order"},
    {"orientation.angles", "--void-angles"},
    {"orientation.axis", "--void-axis"},
    {"orientation.field", "--void-field"},
    {"outUnit", "--out-unit"},
    {"outputs", "--output"},
    {"packGrid", "--grid"},
    {"packUnit", "--pack-unit"},
    {"vacancySamples", "--places"},
    {"periodic", "--periodic"},
    {"preview.color", "--preview-color"},
    {"preview.cut", "--preview-cut"},
    {"preview.file", "--preview"},
    {"preview.height", "--preview-size"},
    {"preview.width", "--preview-size"},
    {"radius", "--radius"},
    {"repair", "--repair"},
    {"repairComponents", "--repair-components"},
    {"repairVoxel", "--repair-voxel"},
    {"reportFile", "--report"},
    {"scale", "--scale"},
    {"seed", "--seed"},
    {"shell", "--shell"},
    {"shellField", "--shell-field"},
    {"shellFrom", "--shell-from"},
    {"shellRadius", "--shell-radius"},
    {"sizeField", "--size-field"},
    {"slice", "--slice"},
    {"sphereMorphometry", "--morphometry"},
    {"table", "--table"},
    {"targetBvtv", "--target-bvtv"},
    {"bvtvField", "--bvtv-field"},
    {"bvtvRange", "--bvtv-range"},
    {"targetCount", "--target-count"},
    {"targetTbth", "--target-tbth"},
    {"threads", "--threads"},
    {"threshold", "--threshold"},
    {"unit", "--unit"},
    {"voids", "--voids"},
    {"voids.aspect", "--void-aspect"},
    {"voids.blend", "--void-blend"},
    {"voids.count", "--void-count"},
    {"voids.jitter", "--void-jitter"},
    {"voids.strut", "--void-strut"},
    {"voids.strutShare", "--void-strut-share"},
    {"targetTbsp", "--target-tbsp"},
    {"targetDa", "--target-da"},
    {"targetConnd", "--target-connd"},
    {"like", "--like"},
    {"likeDomain", "--like-domain"},
    {"likeThreshold", "--like-threshold"},
    {"trabecular", "--trabecular"},
    {"voids.probability", "--void-probability"},
    {"voids.radius", "--void-radius"},
    {"voids.shell", "--shell"},
    {"voids.voxelSize", "--void-voxel"},
    {"voxelSize", "--voxel"},
    {"weightBy", "--weight-by"},
    {"label", "--label"},
    {"partsFile", "--parts"},
    {"samples", "--sample"},
    {"calibration", "--calibrate"},
    {"grey.classes", "--density-classes"},
    {"modulus", "--modulus"},
    {"space", "--space"},
    {"voxelSpacing", "--voxel-spacing"},
};

}  // namespace

std::string withOptionNames(const std::string& message) {
    std::string text;
    std::size_t at = 0;
    for (;;) {
        const std::size_t open = message.find('`', at);
        const std::size_t close = open == std::string::npos ? open : message.find('`', open + 1);
        if (close == std::string::npos) return text + message.substr(at);
        text += message.substr(at, open - at);
        const std::string_view name = std::string_view(message).substr(open + 1, close - open - 1);
        const auto* const known =
            std::find_if(std::begin(kOptionNames), std::end(kOptionNames),
                         [&](const OptionName& o) { return o.parameter == name; });
        if (known == std::end(kOptionNames)) {  // another use of backquotes
            text += '`';
            at = open + 1;
            continue;
        }
        text += known->option;
        at = close + 1;
    }
}
