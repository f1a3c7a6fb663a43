#include "vdbpack/options/command_line.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/recipe_file.h"
#include "vdbpack/options/recipe_toml.h"
#include "vdbpack/options/usage_error.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <type_traits>
#include <utility>

namespace vdbpack {

namespace {

/// Refuses 20,000, which is no list of 20 and 0. @throws ParameterError
void refuseThousands(const std::string& name, const std::string& text) {
    std::string digits = text;
    digits.erase(std::remove(digits.begin(), digits.end(), ','), digits.end());
    const auto values = splitAt(text, ',');
    const auto isThree = [](const std::string& value) {
        return value.size() == 3 && value.find_first_not_of("0123456789") == std::string::npos;
    };
    if (values.size() < 2 || values[1].substr(0, 1) != "0" || values[0].size() > 3 ||
        digits.find_first_not_of("0123456789") != std::string::npos ||
        !std::all_of(values.begin() + 1, values.end(), isThree))
        return;
    throw ParameterError(
        fmt::format("`{}`: '{}' has commas between its digits; write {}", name, text, digits));
}

/// Whether a study may give an option several values.
bool canVary(const Option& option) {
    return option.inRecipes && option.name != "seed" &&
           (option.kind == OptionKind::number || option.kind == OptionKind::length ||
            option.kind == OptionKind::count);
}

/// @param studies  whether numbers may be lists.
void add(CLI::App& app, const Option& option, bool studies) {
    const std::string help = withOptionNames(option.help);
    const std::string letter = option.letter.empty() ? "" : '-' + option.letter + ',';
    const std::string names = letter + optionName(option.name);
    CLI::Option* added = nullptr;
    if (option.kind == OptionKind::flag)
        added = app.add_flag_callback(
            names, [&option] { option.set("true"); }, help);
    else
        added = app.add_option(
            names,
            [&option, lists = studies && canVary(option)](const CLI::results_t& texts) {
                for (const std::string& text : texts) {
                    if (lists) refuseThousands(option.name, text);
                    for (const std::string& value :
                         lists ? splitAt(text, ',') : CLI::results_t{text})
                        option.set(value);
                }
                return true;
            },
            help);
    if (added->nonpositional()) added->option_text(option.shown)->group(option.group);
    if (option.repeats) {
        added->expected(1, CLI::detail::expected_max_vector_size)->take_all();
        added->allow_extra_args(false);
    }
    if (option.required) added->required();
    if (!option.words.empty())
        added->type_name(fmt::format("{}", fmt::join(option.words, "|")));  // for `wordsOf`
    if (option.name == "trabecular")
        added->each([](const std::string& name) {
            if (name == "list") throw CLI::CallForVersion(presetTable(), 0);
        });
}

/// Refuses options that exclude, or lack, one another.
void requireRelated(const Command& command) {
    const auto isGiven = [&](const std::string& name) {
        return command.app->get_option(optionName(name))->count() > 0;
    };
    const auto marked = [](const std::string& name) { return '`' + name + '`'; };
    for (const Option& option : command.options) {
        if (!isGiven(option.name)) continue;
        if (!option.excludes.empty() && isGiven(option.excludes))
            throw CLI::ExcludesError(marked(option.name), marked(option.excludes));
        if (!option.needs.empty() && !isGiven(option.needs))
            throw CLI::RequiresError(marked(option.name), marked(option.needs));
    }
}

/// @param studies  whether numbers may be lists, in commands that make studies.
Command commandIn(CLI::App& app, const CommandText& text, PrintOptions& print,
                  bool studies = false) {
    Command command{app.add_subcommand(text.name, text.help), std::make_unique<Job>(text.job), {}};
    command.options = optionsOf(*command.job, print);
    studies = studies && (std::holds_alternative<PackJob>(text.job) ||
                          std::holds_alternative<VoidsJob>(text.job));
    for (const Option& option : command.options) add(*command.app, option, studies);
    return command;
}

/// Whether parts share an option: it says what is done with all of their spheres.
bool isOfRun(const Option& option) {
    return option.group == "Output" || option.group == "Bonds" || option.group == "Run" ||
           option.name == "out-unit";
}

/// The parts of a parts file: each has the options of the command line but for its own.
/// @param base  those options, without a domain.
std::vector<PackRecipe> partsIn(const std::string& file, const PackJob& base) {
    std::vector<PackRecipe> parts;
    const auto fail = [](const std::string& what) { throw CLI::ValidationError("`parts`", what); };
    if (!base.domain.source.empty())
        fail("the parts have domains of their own; leave out '" + base.domain.source + "'");
    for (PartWords& words : readPartsFile(file, &fileIn)) {
        PrintOptions unused;
        CLI::App app;
        Command command = commandIn(app, {"pack", "", base}, unused);
        PackJob& part = std::get<PackJob>(*command.job);
        part.name = words.name;
        const std::string where = file + ": part '" + part.name + "': ";
        words.arguments.insert(words.arguments.begin(), "pack");
        try {
            app.parse(std::vector<std::string>(words.arguments.rbegin(), words.arguments.rend()));
            requireRelated(command);
            part.voids = voidsOf(part.request);
            if (part.domain.source.find(':') == std::string::npos) requireThere(part.domain.source);
        } catch (const IoError& e) {
            throw IoError(where + e.what());
        } catch (const CLI::ParseError& e) {  // options as the file writes them
            fail(where +
                 usageError(app, e, words.arguments, [](const std::string& n) { return n; }));
        } catch (const ParameterError& e) {
            fail(where + e.what());
        }
        if (!part.partsFile.empty()) fail("parts have no parts of their own");
        for (const Option& option : command.options)
            if (isOfRun(option) && command.app->get_option(optionName(option.name))->count() > 0)
                fail(fmt::format("{}`{}` is of all parts; give it outside of the file{}", where,
                                 option.name,
                                 option.name == "bond-modulus" ? ", or the part a `modulus`" : ""));
        parts.push_back(std::move(part));
    }
    return parts;
}

bool addParts(PackJob& job) {
    if (job.partsFile.empty()) return false;
    PackJob base = job;
    base.partsFile.clear();
    job.parts = partsIn(job.partsFile, base);
    return true;
}

/// Whether a job has options of voids.
template <class Recipe>
constexpr bool kHasVoids = std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VoidsJob> ||
                           std::is_same_v<Recipe, CarveJob>;

bool addParts(VerifyRecipe& job) {
    if (job.partsFile.empty()) return false;
    PackJob base;
    base.domain = std::exchange(job.domain, {});
    job.parts = partsIn(job.partsFile, base);
    return true;
}

/// The hash of the run that a command repeats by its recipe, as far as words show.
std::optional<std::uint64_t> repeatedHash(const Command& command,
                                          const std::vector<std::string>& words) {
    static const std::set<std::string> kSame{"config",   "quiet",  "json",   "output",
                                             "out-unit", "report", "threads"};
    const CLI::App* all = command.app->get_parent();
    const CLI::Option* config = all ? all->get_config_ptr() : nullptr;
    if (!config || config->count() == 0) return std::nullopt;
    for (const std::string& word : words)
        if (startsWith(word, optionName("")) &&
            kSame.count(word.substr(2, word.find('=') - 2)) == 0)
            return std::nullopt;
    return statedHash(config->as<std::string>());
}

/// Refuses to write over a page, picture or table that the recipe names, where the words name other
/// outputs: it shows the pack of the recipe.
void keepShown(const Command& command, const std::vector<std::string>& words) {
    const auto named = [&](const std::string& name) {
        return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
            return word.substr(0, word.find('=')) == optionName(name);
        });
    };
    const CLI::Option* config = command.app->get_parent()->get_config_ptr();
    const bool elsewhere =
        named("output") || std::any_of(words.begin(), words.end(), [](const std::string& word) {
            return startsWith(word, "-o");
        });
    if (!elsewhere || config == nullptr || config->count() == 0) return;
    for (const char* name : {"report", "preview", "table"}) {
        const CLI::Option* const option = command.app->get_option_no_throw(optionName(name));
        if (option == nullptr || option->count() == 0 || named(name)) continue;
        const auto file = option->as<std::string>();
        if (file.empty() || !std::filesystem::exists(file)) continue;
        throw CLI::ValidationError(
            fmt::format("`{}`", name),
            fmt::format("{} is there, and {} names it for other outputs than this run's; give `{}` "
                        "another name",
                        file, config->as<std::string>(), name));
    }
}

/// Adds the parts file to the recipe as a comment: it may change.
void addPartsText(PackJob& job) {
    std::ifstream file(job.partsFile);
    job.optionsText += "\n# " + printable(job.partsFile) + " was:\n";
    for (std::string line; std::getline(file, line);)
        job.optionsText += "#   " + printable(line) + '\n';
}

/// Refuses a parts file that is missing where a recipe has its text. @throws IoError
void requireParts(const Command& command, const std::string& file) {
    const CLI::Option* config = command.app->get_parent()->get_config_ptr();
    if (file.empty() || !config || config->count() == 0 || std::filesystem::exists(file)) return;
    const std::string recipe = config->as<std::string>();
    if (holdsPartsText(recipe))
        throw IoError(fmt::format(
            "{0}: does not exist, but {1} ends with its text as comments; to get it back, run: sed "
            "'1,/^# .* was:$/d; s/^#   //' {2} > {3}",
            file, recipe, shellQuoted(recipe), shellQuoted(file)));
}

void complete(const Command& command, const std::vector<std::string>& words) {
    requireRelated(command);
    keepShown(command, words);
    std::visit(
        [&](auto& recipe) {
            DomainRecipe& domain = recipe.domain;
            if (domain.source.empty()) domain.source = domain.cavities.outer;
            bool hasParts = false;
            using Recipe = std::decay_t<decltype(recipe)>;
            if constexpr (std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VerifyRecipe>) {
                requireParts(command, recipe.partsFile);
                hasParts = addParts(recipe);
            }
            if (domain.source.empty() && !hasParts && command.app->get_option_no_throw("DOMAIN"))
                throw CLI::RequiredError("DOMAIN");
            if constexpr (kHasVoids<Recipe>) recipe.voids = voidsOf(recipe.request);
            recipe.givenOptions = givenOptions(recipe);
            const std::filesystem::path left = recipeFileFor(recipe.outputs);
            recipe.optionsText =
                recipeText(*command.app, command.options, left.parent_path().string());
            if constexpr (std::is_same_v<Recipe, PackJob>)
                if (hasParts && !recipe.optionsText.empty()) addPartsText(recipe);
            recipe.repeatedHash = repeatedHash(command, words);
            for (const auto& word : words)
                recipe.command += (recipe.command.empty() ? "" : " ") + shellQuoted(word);
        },
        *command.job);
}

/// The options of a command with several values, and these.
std::vector<std::pair<std::string, std::vector<std::string>>> variedIn(const Command& command) {
    std::vector<std::pair<std::string, std::vector<std::string>>> varied;
    const auto table = command.app->get_option_no_throw(optionName("table"));
    if (table == nullptr) return varied;
    for (const Option& option : command.options) {
        const auto texts = command.app->get_option(optionName(option.name))->results();
        if (!canVary(option) || texts.empty()) continue;
        const auto values = splitAt(texts.front(), ',');
        if (values.size() < 2) continue;
        // 3000,5000 are two numbers; 0,5 may be one.
        const bool comma = values.size() == 2 && values[0].size() < 4 &&
                           texts.front().find('.') == std::string::npos;
        if (table->count() == 0)
            throw CLI::ValidationError(
                '`' + option.name + '`',
                fmt::format(
                    "'{}' is a list of {} values for a study; set `table` for its results, "
                    "or give one number{}",
                    texts.front(), values.size(),
                    comma ? "; decimals have a point: " + values[0] + '.' + values[1] : ""));
        varied.emplace_back(option.name, values);
    }
    return varied;
}

/// The command with one value of each option that varies, which also stands for the option's name
/// in braces in the names of files.
Job caseOf(const Command& all, const std::vector<std::pair<std::string, std::string>>& varied,
           const std::vector<std::string>& words) {
    CLI::App app;
    PrintOptions unused;
    Job defaults = *all.job;
    std::visit([](auto& job) { job = std::decay_t<decltype(job)>(); }, defaults);
    const Command one = commandIn(app, {all.app->get_name().c_str(), "", defaults}, unused);
    for (std::size_t k = 0; k < all.options.size(); ++k) {
        const std::string& name = one.options[k].name;
        for (std::string text : all.app->get_option(optionName(name))->results()) {
            for (const auto& [option, value] : varied)
                text = option == name ? value : withOption(text, option, value);
            one.options[k].set(text);
            one.app->get_option(optionName(name))->add_result(text);
        }
    }
    complete(one, words);
    std::visit([&](auto& job) { job.varied = varied; }, *one.job);
    return *one.job;
}

/// A study whose options have several values: one case for each combination of them.
template <class StudyJob>
void addCases(StudyJob& job, const Command& command, const std::vector<std::string>& words) {
    const auto lists = variedIn(command);
    if constexpr (std::is_same_v<StudyJob, PackJob>)
        if (job.dryRun && !lists.empty())
            throw CLI::ValidationError(
                "`dry-run`", "predicts one run; give one value of `" + lists.front().first + '`');
    std::size_t cases = 1;
    for (const auto& [name, values] : lists) cases *= values.size();
    for (std::size_t k = 0; !lists.empty() && k < cases; ++k) {
        std::vector<std::pair<std::string, std::string>> varied;
        std::size_t each = cases, left = k;
        for (const auto& [name, values] : lists) {
            each /= values.size();
            varied.emplace_back(name, values[left / each]);
            left %= each;
        }
        job.cases.push_back(std::get<StudyJob>(caseOf(command, varied, words)));
    }
}

}  // namespace

std::vector<Command> addCommands(CLI::App& app, PrintOptions& print) {
    app.set_config(
           optionName("config"), "",
           "read options of the command from a TOML file, under the same names; the command "
           "line takes precedence. Each run writes such a file, NAME.recipe.toml, beside "
           "its first output, to repeat the run")
        ->option_text("FILE")
        ->check([](const std::string& file) {
            const bool missing = !CLI::ExistingPath(file).empty();
            return CLI::ExistingFile(file) + (missing ? similarFile(file) : "");
        });
    app.config_formatter(std::make_shared<RecipeFormat>(app, &fileIn));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();
    std::vector<Command> commands;
    for (const CommandText& text : commandTexts())
        commands.push_back(commandIn(app, text, print, true));
    return commands;
}

std::optional<Job> parsedJob(std::vector<Command>& commands,
                             const std::vector<std::string>& words) {
    const auto command = std::find_if(commands.begin(), commands.end(),
                                      [](const Command& c) { return c.app->parsed(); });
    if (command == commands.end()) return std::nullopt;
    const bool varies = !variedIn(*command).empty();
    if (!varies) complete(*command, words);
    std::visit(
        [&](auto& job) {
            using StudyJob = std::decay_t<decltype(job)>;
            if constexpr (std::is_same_v<StudyJob, PackJob> || std::is_same_v<StudyJob, VoidsJob>)
                addCases(job, *command, words);
        },
        *command->job);
    return std::move(*command->job);
}

Job jobOf(const std::vector<std::string>& words, const std::vector<std::string>& unset,
          OptionStyle style) {
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
                throw ParameterError(unknownOption(app, *parsed.front(), option, style));
        return *parsedJob(commands, words);
    } catch (const CLI::ParseError& e) {
        throw ParameterError(usageError(app, e, words, style));
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

std::vector<std::string> wordsOf(const CLI::Option& option) {
    auto words = splitAt(option.get_type_name(), '|');
    if (words.size() < 2) words.clear();
    return words;
}

}  // namespace vdbpack
