#include "vdbpack/options/usage_error.h"

#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace vdbpack {

namespace {

std::vector<std::string> commandsOf(const CLI::App& app) {
    std::vector<std::string> names;
    for (const auto* command : app.get_subcommands({}))
        if (!command->get_group().empty()) names.push_back(command->get_name());
    return names;
}

/// The command that is named first, if it is one.
const CLI::App* commandOf(const CLI::App& app, const std::vector<std::string>& arguments) {
    for (const auto& word : arguments)
        for (const CLI::App* command : app.get_subcommands({}))
            if (command->get_name() == word) return command;
    return nullptr;
}

/// An option as the parser writes it, in another style; a single letter as it is.
std::string restyled(const std::string& word, OptionStyle style) {
    const std::string name = word.substr(std::min(word.find_first_not_of('-'), word.size()));
    return !name.empty() && optionName(name) == word ? style(name) : word;
}

constexpr const char* kNoMaterial =
    "spheres have no material: `shell` sets their region, which is the type in LAMMPS, LIGGGHTS "
    "and YADE, and `density` their density";

/// What other programs have, and what there is here.
struct ForeignOption {
    const char* name;
    const char* instead;
};
constexpr ForeignOption kForeignOptions[] = {
    {"boundary", "periodic:LX,LY,LZ repeats along all axes, `periodic` xy makes a box repeat"},
    {"lattice", "there are no lattices; `order` and `effort` choose how the front fills"},
    {"material", kNoMaterial},
    {"materials", kNoMaterial},
    {"young", "elastic constants belong to the DEM program; `density` is written to its files"},
    {"friction", "friction belongs to the DEM program; `density` is written to its files"},
    {"porosity",
     "`densify` F sets the solid fraction of the spheres, `voids` METHOD with `target-bvtv` F the "
     "bone volume fraction"},
    {"diameter", "`radius` SPEC sets the radii, half of the diameters, mm"},
    {"diameters", "`radius` SPEC sets the radii, half of the diameters, mm"},
    {"size", "`radius` SPEC sets the radii, half of the diameters, mm"},
    {"number", "`target-count` N scales the radii so that about N spheres fill the domain"},
    {"count", "`target-count` N scales the radii so that about N spheres fill the domain"},
    {"min-radius", "`radius` uniform:A,B sets both ends"},
    {"max-radius", "`radius` uniform:A,B sets both ends"},
    {"format", "the extension of -o FILE chooses the format"},
};

}  // namespace

std::string unknownOption(const CLI::App& app, const CLI::App& command, const std::string& word,
                          OptionStyle style) {
    const std::string shown = restyled(word, style);
    for (const ForeignOption& foreign : kForeignOptions)
        if (word == optionName(foreign.name))
            return fmt::format("{} is not an option of vdb_pack: {}", shown, foreign.instead);
    std::vector<std::string> names;
    for (const CLI::App* a : {&command, &app})
        for (const auto* option : a->get_options())
            for (const auto& name : option->get_lnames())
                if (!option->get_group().empty()) names.push_back(optionName(name));
    const std::string like = restyled(mostLike(word, names), style);
    std::string others;
    for (const auto* other : app.get_subcommands({}))
        if (other != &command && other->get_option_no_throw(word) != nullptr)
            others += (others.empty() ? "" : ", ") + other->get_name();
    return fmt::format("{} is not an option of {}{}", shown, command.get_name(),
                       !others.empty() ? ", but of " + others
                       : like.empty()  ? ""
                                       : "; did you mean " + like + "?");
}

std::string usageError(const CLI::App& app, const CLI::ParseError& error,
                       const std::vector<std::string>& arguments, OptionStyle style) {
    const CLI::App* const command = commandOf(app, arguments);
    const std::string message = error.what();
    const bool unexpected = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    if (command == nullptr) {
        const auto commands = commandsOf(app);
        auto word = arguments.begin();
        while (word != arguments.end() && (word->empty() || word->front() == '-'))
            word += *word == optionName("config") && word + 1 != arguments.end() ? 2 : 1;
        if (word == arguments.end())
            return fmt::format("a command is needed: {}", fmt::join(commands, ", "));
        const std::string like = mostLike(*word, commands);
        return fmt::format("'{}' is not a command{}", *word,
                           like.empty() ? fmt::format("; use one of {}", fmt::join(commands, ", "))
                                        : "; did you mean " + like + "?");
    }
    if (unexpected) {
        for (const auto& word : arguments) {
            const std::string name = word.substr(0, word.find('='));
            if (name.size() > 1 && name.front() == '-' &&
                name.find_first_not_of("-0123456789.") != std::string::npos &&
                command->get_option_no_throw(name) == nullptr &&
                app.get_option_no_throw(name) == nullptr)
                return unknownOption(app, *command, name, style);
        }
        const auto colon = message.find(": ");
        return fmt::format("{} does not take the argument {}{}", command->get_name(),
                           colon == std::string::npos ? message : message.substr(colon + 2),
                           command->get_name() == "pack"
                               ? "; several domains are parts: `parts` FILE.toml lists them"
                               : "");
    }
    const auto subject = [&](std::size_t end) { return restyled(message.substr(0, end), style); };
    // report: "At Most 1 required but received 2"; later "At most"
    const auto most = lowered(message).find(": at most 1 required but received ");
    if (most != std::string::npos)
        return fmt::format("{} is given {} times, but takes one value", subject(most),
                           message.substr(message.rfind(' ') + 1));
    // voxel: "1 required FLOAT missing"
    if (const auto none = message.find(": 1 required "); none != std::string::npos)
        return subject(none) + ": a value is missing";
    // "Could not convert: --voxel = 1x"
    const std::string failed = "Could not convert: ";
    const auto equals = message.find(" = ");
    if (message.rfind(failed, 0) == 0 && equals != std::string::npos)
        return fmt::format("{}: '{}' is not a number",
                           message.substr(failed.size(), equals - failed.size()),
                           message.substr(equals + 3));
    return message;
}

}  // namespace vdbpack
