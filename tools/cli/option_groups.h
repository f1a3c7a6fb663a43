// Options that several commands share, in the groups that the help shows.
#pragma once

#include "cli/completion.h"
#include "cli/options.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

extern const char* const kDomainHelp;
/// What -o of runs with spheres takes.
extern const char* const kOutputHelp;
/// What --report of most runs writes.
extern const char* const kReportHelp;
/// What there is to read as a pack.
extern const char* const kPackHelp;

/// CLI11's own range checks print a range of 300 digits.
CLI::Validator positive();
CLI::Validator notNegative();
/// For `transform`: also 1e6, which it writes out.
/// @param remedy  what to do instead, for the message; may be empty.
CLI::Validator wholeNumber(std::uint64_t least, std::uint64_t most, const std::string& remedy = {});
CLI::Validator notEmpty();

/// Names of values, in the order in which they are listed.
template <class Value>
using Names = std::vector<std::pair<std::string, Value>>;

/// An option that takes one of some names; the first of those that mean its value is the default.
template <class Value>
CLI::Option* addChoice(CLI::App& command, const std::string& option, Value& value,
                       const Names<Value>& names, const std::string& help) {
    const auto set = [&value, &names, option](const std::string& text) {
        for (const auto& [name, meaning] : names)
            if (name == text) {
                value = meaning;
                return;
            }
        std::string all;
        for (const auto& [name, meaning] : names) all += (all.empty() ? "" : ", ") + name;
        throw CLI::ValidationError(option, "'" + text + "' is not one of " + all);
    };
    auto* added = command.add_option_function<std::string>(option, set, help);
    std::vector<std::string> words;
    for (const auto& [name, meaning] : names) {
        words.push_back(name);
        if (meaning == value && added->get_default_str().empty()) added->default_str(name);
    }
    setWords(*added, words);
    return added;
}

/// Where an image lies: distances of voxels and the axes of the world.
void addImageOptions(CLI::App& command, vdbpack::DomainRecipe& domain);
void addImagePlacement(CLI::App& command, vdbpack::DomainRecipe& domain);
void addUnit(CLI::App& command, const std::string& option, vdbpack::Unit& unit,
             const std::string& help);
void addOutputs(CLI::App& command, std::vector<std::string>& outputs, const std::string& help);
void addContactTolerance(CLI::App& command, double& tolerance);
void addImages(CLI::App& command, bool& images);
/// --gap.
void addGap(CLI::App& command, double& gap);
void addDensify(CLI::App& command, double& fraction, const std::string& help);
void addThreads(CLI::App& command, int& threads, const std::string& help);
void addRepairOptions(CLI::App& command, vdbpack::DomainRecipe& domain);
void addMemoryLimit(CLI::App& command, double& bytes);
void addDomainOptions(CLI::App& command, vdbpack::DomainRecipe& domain);
/// --shell-from.
void addShellFrom(CLI::App& command, vdbpack::DomainRecipe& domain, const std::string& group);
void addSizeOptions(CLI::App& command, std::string& radius, vdbpack::WeightBy& weightBy,
                    const std::string& note);
/// --sample, --calibrate, --modulus, --density-classes.
void addGreyOptions(CLI::App& command, vdbpack::GreyRecipe& grey);
void addDensityOption(CLI::App& command, std::string& density);
/// A pack of a file as the positional `name`, and what to compare it with.
void addInputPack(CLI::App& command, vdbpack::InputPack& input, const char* name,
                  const std::string& help);
/// --report.
void addReport(CLI::App& command, std::string& file, const std::string& help);
/// --json and --quiet.
void addPrinting(CLI::App& command, PrintOptions& print);
/// Options of all runs with one seed. @param random  what it decides: "of the voids".
void addRunOptions(CLI::App& command, std::uint64_t& seed, std::string& report, PrintOptions& print,
                   const std::string& random);
/// --preview-cut and --preview-color.
void addCutAndColor(CLI::App& command, vdbpack::PreviewRecipe& preview);
void addPreviewOptions(CLI::App& command, vdbpack::PreviewRecipe& preview);

/// What there is to cut: spheres while they are packed, those of a file, or none.
enum class VoidsIn { pack, file, nothing };

/// @param domain  that the shell lies in.
void addVoidOptions(CLI::App& command, vdbpack::VoidRecipe& voids, vdbpack::DomainRecipe& domain,
                    VoidsIn in);
