#include "cli/completion.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/command_line.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

using namespace vdbpack;

namespace {

std::string joined(const std::vector<std::string>& words, const char* between) {
    return fmt::format("{}", fmt::join(words, between));
}

/// Options that a person would see, those of the whole program as well.
std::vector<const CLI::Option*> optionsOf(const CLI::App& command) {
    std::vector<const CLI::Option*> options;
    for (const CLI::App* app = &command; app != nullptr; app = app->get_parent())
        for (const auto* option : app->get_options())
            if (option->nonpositional() && !option->get_group().empty() &&
                std::none_of(options.begin(), options.end(), [&](const auto* other) {
                    return other->get_name() == option->get_name();
                }))
                options.push_back(option);
    return options;
}

std::string bashScript(const CLI::App& app) {
    std::vector<std::string> commands;
    std::string cases;
    for (const auto* command : app.get_subcommands({})) {
        commands.push_back(command->get_name());
        std::vector<std::string> names;
        std::string words;
        for (const auto* option : optionsOf(*command)) {
            const auto own = splitAt(option->get_name(false, true), ',');
            names.insert(names.end(), own.begin(), own.end());
            const auto known = wordsOf(*option);
            if (!known.empty())
                words += fmt::format("            {}) words=\"{}\" ;;\n", joined(own, "|"),
                                     joined(known, " "));
        }
        cases += fmt::format("    {})\n        options=\"{}\"\n", command->get_name(),
                             joined(names, " "));
        for (const auto* option : command->get_options())
            if (option->get_positional() && !wordsOf(*option).empty())
                cases += fmt::format("        words=\"{}\"\n", joined(wordsOf(*option), " "));
        if (!words.empty()) cases += "        case \"$before\" in\n" + words + "        esac\n";
        cases += "        ;;\n";
    }
    return fmt::format(R"(_vdb_pack() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
    local commands="{}" options="" words=""
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "$commands --help --version" -- "$word"))
        return
    fi
    case "${{COMP_WORDS[1]}}" in
{}    esac
    if [ -n "$words" ]; then
        COMPREPLY=($(compgen -W "$words" -- "$word"))
    elif [[ "$word" == -* ]]; then
        COMPREPLY=($(compgen -W "$options" -- "$word"))
    else
        COMPREPLY=($(compgen -f -- "$word"))
    fi
}}
complete -o filenames -F _vdb_pack vdb_pack
)",
                       joined(commands, " "), cases);
}

std::string fishQuoted(std::string text) {
    for (std::size_t at = 0; (at = text.find_first_of("'\\", at)) != std::string::npos; at += 2)
        text.insert(at, "\\");
    return "'" + text + "'";
}

std::string fishScript(const CLI::App& app) {
    std::string out;
    for (const auto* command : app.get_subcommands({})) {
        out += fmt::format("complete -c vdb_pack -n __fish_use_subcommand -a {} -d {}\n",
                           command->get_name(), fishQuoted(command->get_description()));
        for (const auto* option : optionsOf(*command)) {
            out += fmt::format("complete -c vdb_pack -n '__fish_seen_subcommand_from {}'",
                               command->get_name());
            for (const auto& name : option->get_lnames()) out += " -l " + name;
            for (const auto& name : option->get_snames()) out += " -s " + name;
            const auto words = wordsOf(*option);
            if (!words.empty())
                out += " -x -a " + fishQuoted(joined(words, " "));
            else if (option->get_expected_max() > 0)
                out += " -r";
            out += " -d " + fishQuoted(option->get_description()) + '\n';
        }
    }
    return out;
}

}  // namespace

std::string completionScript(const CLI::App& app, const std::string& shell) {
    if (shell == "bash") return bashScript(app);
    if (shell == "zsh") return "autoload -U +X bashcompinit && bashcompinit\n" + bashScript(app);
    if (shell == "fish") return fishScript(app);
    throw ParameterError("'" + shell + "' is not one of bash, zsh, fish");
}
