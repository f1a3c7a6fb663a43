// The commands of the program: what each does, and the table of its options.
#pragma once

#include "vdbpack/options/option.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/options/void_request.h"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace vdbpack {

/// Runs of one recipe.
struct Study {
    std::vector<std::uint64_t> seeds{1};  ///< one run each
    std::string table;                    ///< .csv with a row a run; empty: none

    bool isOne() const { return seeds.size() == 1 && table.empty(); }
};

/// Jobs with voids: `voids` are those of the request once the words are parsed.
struct PackJob : PackRecipe {
    VoidRequest request;
    Study study;
    std::vector<PackRecipe> cases;  ///< of a study that varies options; empty: this one
    bool dryRun = false;
};

struct VoidsJob : VoidsRecipe {
    VoidRequest request;
    Study study;
    std::vector<VoidsRecipe> cases;
};

struct CarveJob : CarveRecipe {
    VoidRequest request;
};

struct ViewJob : ViewRecipe {
    bool opens = true;  ///< the page, where there is a display
};

/// The recipe of a command. All have `domain` and the fields of RunSettings.
using Job = std::variant<PackJob, VoidsJob, CarveJob, DensifyRecipe, VerifyRecipe, MeasureRecipe,
                         StiffnessRecipe, ConvertRecipe, MeshRecipe, ImageRecipe, ViewJob>;

/// How the result is printed.
struct PrintOptions {
    bool json = false;
    bool quiet = false;
};

/// A command and its effect, in the order of the help.
struct CommandText {
    const char* name;
    const char* help;
    Job job;  ///< with defaults
};
const std::vector<CommandText>& commandTexts();

/// The options of a job, bound to its fields, in the order of the help. The job and `print` must
/// outlive them.
std::vector<Option> optionsOf(Job& job, PrintOptions& print);

/// Where the value of an option of that name holds a file, in any command.
FileIn fileIn(const std::string& option);

/// The text with each option that stands between backquotes, by its name or by the field of a
/// recipe that it sets, such as `targetCount`, in a style.
std::string withOptionNames(const std::string& message, OptionStyle style = optionName);

/// Name and value of each option of a job that differs from its default, for the page of a report.
std::vector<std::pair<std::string, std::string>> givenOptions(Job job);

/// "7", "1..50" or "1,4,9..12" as seeds, in that order.
/// @throws ParameterError for anything else, a range that falls, a seed named twice, or more than
/// a million seeds.
std::vector<std::uint64_t> parseSeeds(const std::string& text);

}  // namespace vdbpack
