#include "cli/help.h"

#include "vdbpack/io/text.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace {

constexpr std::size_t kNames = 24;  ///< columns that names take, before what they do

}  // namespace

std::string HelpPage::heading(const std::string& text) const {
    return colored_ ? "\x1b[1m" + text + "\x1b[0m" : text;
}

std::string HelpPage::row(const std::string& name, const std::string& text) const {
    std::string out = "  " + name;
    if (out.size() + 2 > kNames)
        out += '\n' + std::string(kNames, ' ');
    else
        out.resize(kNames, ' ');
    return out + vdbpack::wrapped(text, columns_, kNames, kNames) + '\n';
}

std::string HelpPage::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const {
    const std::string footer = make_footer(app);
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) +
           groupsOf(app) + commandsOf(app) + (footer.empty() ? "" : '\n' + footer);
}

std::string HelpPage::make_usage(const CLI::App* app, std::string) const {
    std::string line;
    for (const CLI::App* a = app; a != nullptr; a = a->get_parent())
        line = (a->get_parent() == nullptr ? std::string("vdb_pack") : a->get_name()) +
               (line.empty() ? "" : " " + line);
    for (const auto* option : app->get_options())
        if (option->get_positional()) line += ' ' + option->get_name(true, false);
    const bool commands = app->get_parent() == nullptr;
    line += commands ? " COMMAND [options]" : " [options]";
    if (app->get_option_no_throw("--output") != nullptr) line += " [-o FILE ...]";
    std::string out = '\n' + heading("Usage") + "  " + line + '\n';
    if (commands) out += "       vdb_pack COMMAND --help\n";
    return out;
}

std::string HelpPage::make_group(std::string group, bool positional,
                                 std::vector<const CLI::Option*> options) const {
    std::string out = '\n' + heading(positional ? "Input" : group) + '\n';
    for (const auto* option : options) out += make_option(option, positional);
    return out;
}

/// Those of CLI11 itself stand last.
std::string HelpPage::groupsOf(const CLI::App* app) const {
    std::vector<std::string> groups = app->get_groups();
    std::stable_partition(groups.begin(), groups.end(),
                          [](const std::string& g) { return g != "Options"; });
    std::string out;
    for (const auto& group : groups) {
        const auto options = app->get_options([&](const CLI::Option* option) {
            return option->get_group() == group && option->nonpositional();
        });
        if (!group.empty() && !options.empty()) out += make_group(group, false, options);
    }
    return out;
}

std::string HelpPage::commandsOf(const CLI::App* app) const {
    std::string out;
    for (const auto* command : app->get_subcommands({})) out += make_subcommand(command);
    return out.empty() ? out : '\n' + heading("Commands") + '\n' + out;
}

std::string HelpPage::make_option(const CLI::Option* option, bool positional) const {
    std::string name = option->get_name(positional, !positional);
    if (const auto comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
    if (!positional && !option->get_option_text().empty()) name += ' ' + option->get_option_text();
    return row(name, option->get_description());
}

std::string HelpPage::make_subcommand(const CLI::App* app) const {
    return row(app->get_name(), app->get_description());
}

std::string HelpPage::make_description(const CLI::App* app) const {
    return vdbpack::wrapped(app->get_description(), columns_, 0, 0) + '\n';
}

std::string HelpPage::make_footer(const CLI::App* app) const {
    return app->get_footer().empty() ? ""
                                     : vdbpack::wrapped(app->get_footer(), columns_, 0, 0) + '\n';
}
