#include "vdbpack/options/command_line.h"

#include "vdbpack/core/error.h"
#include "vdbpack/options/recipe_toml.h"
#include "vdbpack/options/usage_error.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <type_traits>
#include <utility>

namespace vdbpack {

namespace {

/// How the parser knows an option: "-o,--output".
std::string parserName(const Option& option) {
    const std::string name = optionName(option.name);
    return option.letter.empty() ? name : '-' + option.letter + ',' + name;
}

/// Sets the field of an option from its texts, one after the other.
bool setAll(const Option& option, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) option.set(text);
    return true;
}

void add(CLI::App& app, const Option& option) {
    CLI::Option* added = nullptr;
    if (option.kind == OptionKind::flag)
        added = app.add_flag_callback(
            parserName(option), [&option] { option.set("true"); }, option.help);
    else
        added = app.add_option(
            parserName(option),
            [&option](const CLI::results_t& texts) { return setAll(option, texts); }, option.help);
    if (added->nonpositional()) added->option_text(option.shown)->group(option.group);
    if (option.repeats) {
        added->expected(1, CLI::detail::expected_max_vector_size)->take_all();
        added->allow_extra_args(false);
    }
    if (option.required) added->required();
    if (!option.words.empty()) setWords(*added, option.words);
    if (option.name == "trabecular")
        added->each([](const std::string& name) {
            if (name == "list") throw CLI::CallForVersion(presetTable(), 0);
        });
}

/// Says which options exclude or need one another.
void relate(CLI::App& app, const Option& option) {
    CLI::Option* const own = app.get_option(optionName(option.name));
    if (!option.excludes.empty()) own->excludes(app.get_option(optionName(option.excludes)));
    if (!option.needs.empty()) own->needs(app.get_option(optionName(option.needs)));
}

Command commandIn(CLI::App& app, const CommandText& text, PrintOptions& print) {
    Command command{app.add_subcommand(text.name, text.help), std::make_unique<Job>(text.job), {}};
    command.options = optionsOf(*command.job, print);
    for (const Option& option : command.options) add(*command.app, option);
    for (const Option& option : command.options) relate(*command.app, option);
    return command;
}

/// The parts of a parts file: each has the options of the command line but for its own.
/// @param base  those options, without a domain.
std::vector<PackRecipe> partsIn(const std::string& file, const PackJob& base) {
    std::vector<PackRecipe> parts;
    const auto fail = [](const std::string& what) {
        throw CLI::ValidationError(optionName("parts"), what);
    };
    if (!base.domain.source.empty())
        fail("the parts have domains of their own; leave out '" + base.domain.source + "'");
    for (PartWords& words : readPartsFile(file, &fileIn)) {
        PrintOptions unused;
        CLI::App app;
        Command command = commandIn(app, {"pack", "", base}, unused);
        PackJob& part = std::get<PackJob>(*command.job);
        part.name = words.name;
        words.arguments.insert(words.arguments.begin(), "pack");
        std::reverse(words.arguments.begin(), words.arguments.end());
        try {
            app.parse(words.arguments);
            part.voids = voidsOf(part.request);
        } catch (const CLI::ParseError& e) {
            fail(file + ": part '" + words.name + "': " + e.what());
        } catch (const ParameterError& e) {
            fail(file + ": part '" + words.name + "': " + e.what());
        }
        if (!part.partsFile.empty()) fail("parts have no parts of their own");
        if (part.outputs.size() != base.outputs.size() || part.reportFile != base.reportFile ||
            part.preview.file != base.preview.file)
            fail(file + ": part '" + words.name +
                 "': outputs, reports and pictures are of all parts; give them outside of the "
                 "file");
        parts.push_back(std::move(part));
    }
    return parts;
}

void addParts(PackJob& job) {
    if (job.partsFile.empty()) return;
    PackJob base = job;
    base.partsFile.clear();
    job.parts = partsIn(job.partsFile, base);
}

/// Whether a job has options of voids.
template <class Recipe>
constexpr bool kHasVoids = std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VoidsJob> ||
                           std::is_same_v<Recipe, CarveJob>;

void addParts(VerifyRecipe& job) {
    if (job.partsFile.empty()) return;
    PackJob base;
    base.domain = job.domain;
    job.parts = partsIn(job.partsFile, base);
    job.domain = {};
}

void complete(const Command& command, const std::vector<std::string>& words) {
    std::visit(
        [&](auto& recipe) {
            DomainRecipe& domain = recipe.domain;
            if (domain.source.empty()) domain.source = domain.cavities.outer;
            bool hasParts = false;
            using Recipe = std::decay_t<decltype(recipe)>;
            if constexpr (std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VerifyRecipe>) {
                addParts(recipe);
                hasParts = !recipe.parts.empty();
            }
            if (domain.source.empty() && !hasParts && command.app->get_option_no_throw("DOMAIN"))
                throw CLI::RequiredError("DOMAIN");
            if constexpr (kHasVoids<Recipe>) recipe.voids = voidsOf(recipe.request);
            recipe.givenOptions = givenOptions(recipe);
            const std::filesystem::path left = recipeFileFor(recipe.outputs);
            recipe.optionsText =
                recipeText(*command.app, command.options, left.parent_path().string());
            for (const auto& word : words)
                recipe.command += (recipe.command.empty() ? "" : " ") + shellQuoted(word);
        },
        *command.job);
}

}  // namespace

std::vector<Command> addCommands(CLI::App& app, PrintOptions& print) {
    std::vector<Command> commands;
    for (const CommandText& text : commandTexts()) commands.push_back(commandIn(app, text, print));
    return commands;
}

std::optional<Job> parsedJob(std::vector<Command>& commands,
                             const std::vector<std::string>& words) {
    const auto command = std::find_if(commands.begin(), commands.end(),
                                      [](const Command& c) { return c.app->parsed(); });
    if (command == commands.end()) return std::nullopt;
    complete(*command, words);
    return std::move(*command->job);
}

Job jobOf(const std::vector<std::string>& words, const std::vector<std::string>& unset) {
    CLI::App app;
    PrintOptions print;
    std::vector<Command> commands = addCommands(app, print);
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
        const auto parsed = app.get_subcommands();
        if (parsed.empty()) throw ParameterError("no command is named");
        for (const std::string& name : unset)
            if (const std::string option = optionName(name);
                parsed.front()->get_option_no_throw(option) == nullptr &&
                app.get_option_no_throw(option) == nullptr)
                throw ParameterError(unknownOption(app, *parsed.front(), option));
        return *parsedJob(commands, words);
    } catch (const CLI::ParseError& e) {
        throw ParameterError(usageError(app, e, words));
    }
}

std::string shellQuoted(const std::string& word) {
    const char* plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=+@%{}";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

void setWords(CLI::Option& option, const std::vector<std::string>& words) {
    option.type_name(fmt::format("{}", fmt::join(words, "|")));
}

std::vector<std::string> wordsOf(const CLI::Option& option) {
    std::vector<std::string> words;
    std::istringstream name(option.get_type_name());
    for (std::string word; std::getline(name, word, '|');) words.push_back(word);
    if (words.size() < 2) words.clear();
    return words;
}

}  // namespace vdbpack
