// Help that fits the page.
#pragma once

#include <CLI/CLI.hpp>

#include <cstddef>
#include <string>

/// Options by group in two columns within the width of the page, groups in order of their task.
class HelpPage : public CLI::Formatter {
public:
    /// @param columns  of the page.  @param colored  headings are.
    HelpPage(std::size_t columns, bool colored) : columns_(columns), colored_(colored) {}

    std::string make_usage(const CLI::App* app, std::string name) const override;
    std::string make_group(std::string group, bool positional,
                           std::vector<const CLI::Option*> options) const override;
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override;
    std::string make_option(const CLI::Option* option, bool positional) const override;
    std::string make_subcommand(const CLI::App* app) const override;
    std::string make_description(const CLI::App* app) const override;
    std::string make_footer(const CLI::App* app) const override;

private:
    std::string groupsOf(const CLI::App* app) const;
    std::string commandsOf(const CLI::App* app) const;
    std::string heading(const std::string& text) const;
    std::string row(const std::string& name, const std::string& text) const;

    std::size_t columns_;
    bool colored_;
};
