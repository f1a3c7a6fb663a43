#include "cli/man_page.h"

#include "cli/help.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <vector>

using namespace vdbpack;

namespace {

const std::map<char, std::string> kEscapes{{'\\', "\\e"},  {'-', "\\-"},   {'\'', "\\(aq"},
                                           {'`', "\\(ga"}, {'^', "\\(ha"}, {'~', "\\(ti"}};

/// `text` without what roff takes for requests and escapes. Breaks of lines end paragraphs.
std::string escaped(const std::string& text) {
    std::string out;
    bool lineBegins = true;
    for (const char c : text) {
        if (c == '\n') {
            out += out.empty() || lineBegins ? "" : "\n.PP\n";
            lineBegins = true;
            continue;
        }
        if (lineBegins && (c == '.' || c == '\'')) out += "\\&";
        const auto escape = kEscapes.find(c);
        out += escape == kEscapes.end() ? std::string(1, c) : escape->second;
        lineBegins = false;
    }
    return out;
}

std::string nameOf(const CLI::App& app) {
    return app.get_parent() == nullptr ? "vdb_pack" : "vdb_pack-" + app.get_name();
}

/// "vdb_pack pack DOMAIN [options]": the line of --help without its heading.
std::string synopsis(const CLI::App& app) {
    const std::string usage = HelpPage(1000, false).make_usage(&app, "");
    const auto line = usage.substr(1, usage.find('\n', 1) - 1);
    return std::string(trimmed(line.substr(std::string("Usage").size())));
}

std::string optionText(const CLI::Option& option, bool positional) {
    std::string name = option.get_name(positional, !positional);
    if (const auto comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
    std::string out = ".TP\n\\fB" + escaped(name) + "\\fR";
    if (!positional && !option.get_option_text().empty())
        out += " \\fI" + escaped(option.get_option_text()) + "\\fR";
    // Blanks stand between alternatives there; here they would stretch the line.
    std::string text;
    for (Words words(option.get_description());;) {
        const auto word = words.next();
        if (word.empty()) break;
        text.append(text.empty() ? "" : " ").append(word);
    }
    return out + '\n' + escaped(text) + '\n';
}

std::string optionLines(const CLI::App& app) {
    std::string out;
    const auto positionals = app.get_options(
        [](const CLI::Option* o) { return o->get_positional() && !o->get_group().empty(); });
    if (!positionals.empty()) out += ".SH INPUT\n";
    for (const auto* option : positionals) out += optionText(*option, true);
    out += ".SH OPTIONS\n";
    for (const auto& group : app.get_groups()) {
        const auto options = app.get_options([&group](const CLI::Option* o) {
            return o->get_group() == group && o->nonpositional();
        });
        if (group.empty() || options.empty()) continue;
        if (group != "Options") out += ".SS " + escaped(group) + '\n';
        for (const auto* option : options) out += optionText(*option, false);
    }
    return out;
}

std::string seeAlso(const CLI::App& app) {
    std::string out;
    const auto add = [&out](const std::string& name) {
        out += fmt::format("{}.BR {} (1)", out.empty() ? "" : ",\n", escaped(name));
    };
    if (app.get_parent() != nullptr) add(nameOf(*app.get_parent()));
    for (const auto* command : app.get_subcommands({})) add(nameOf(*command));
    return ".SH SEE ALSO\n" + out + '\n';
}

/// What stands after the name.
std::string titleOf(const CLI::App& app) {
    return app.get_parent() == nullptr ? "fill bones with spheres" : app.get_description();
}

}  // namespace

std::string manPage(const CLI::App& app) {
    const std::string name = nameOf(app);
    const CLI::App& program = app.get_parent() == nullptr ? app : *app.get_parent();
    std::string title = name;
    for (char& c : title)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    std::string out = fmt::format(".TH {} 1 \"\" \"vdb_pack {}\" \"vdb_pack\"\n", escaped(title),
                                  VDBPACK_VERSION);
    out += ".nh\n.ad l\n";  // options and file names stay whole
    out += fmt::format(".SH NAME\n{} \\- {}\n", escaped(name), escaped(titleOf(app)));
    out += ".SH SYNOPSIS\n" + escaped(synopsis(app)) + '\n';
    if (app.get_parent() == nullptr) {
        out += ".SH DESCRIPTION\n" + escaped(app.get_description()) + "\n.SH COMMANDS\n";
        for (const auto* command : app.get_subcommands({}))
            out += fmt::format(".TP\n\\fB{}\\fR\n{}\n", escaped(command->get_name()),
                               escaped(command->get_description()));
    }
    out += optionLines(app);
    std::string codes = program.get_footer();
    codes.erase(0, codes.find(':') + 1);  // "Exit codes: 0 done, ..."
    out += ".SH EXIT STATUS\n" + escaped(std::string(trimmed(codes))) + '\n';
    return out + seeAlso(app);
}

void writeManPages(const CLI::App& program, const std::string& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) throw IoError(folder + ": cannot be made: " + failed.message());
    std::vector<const CLI::App*> apps = {&program};
    for (const auto* command : program.get_subcommands({})) apps.push_back(command);
    for (const auto* app : apps) {
        OutputFile out(folder + "/" + nameOf(*app) + ".1");
        out.write(manPage(*app));
        out.commit();
    }
}
