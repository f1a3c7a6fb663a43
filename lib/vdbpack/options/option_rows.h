// Private to options: rows that several commands share.
#pragma once

#include "vdbpack/options/jobs.h"
#include "vdbpack/options/option.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/options/void_request.h"

#include <string>
#include <vector>

namespace vdbpack {

// domain_options.cpp
extern const char* const kDomainHelp;
/// Rows of DOMAIN, where it is the argument of a command.
void domainArgument(OptionList& rows, DomainRecipe& domain);
/// The row `domain`. @param note  before the forms of a domain; may be empty.
void domainOption(OptionList& rows, DomainRecipe& domain, const std::string& note = {},
                  const char* shown = "DOMAIN");
/// @param packGrid  in place of the grid of the domain; null: there is no pack beside it.
void domainOptions(OptionList& rows, DomainRecipe& domain, std::string* packGrid = nullptr);
void thresholdOption(OptionList& rows, DomainRecipe& domain);
void poseOptions(OptionList& rows, Pose& pose);
void imageOptions(OptionList& rows, DomainRecipe& domain);
void imagePlacement(OptionList& rows, DomainRecipe& domain);
void repairOptions(OptionList& rows, DomainRecipe& domain);
void shellFromOption(OptionList& rows, DomainRecipe& domain);
void unitOption(OptionList& rows, const char* name, Unit& unit, const char* help);

// sphere_options.cpp
/// @param name  of the option, for errors. @throws as `SizeDistribution::parse`
SizeRequest sizesOf(const std::string& name, const std::string& text);
void sizeOptions(OptionList& rows, SizeRequest& radius, WeightBy& weightBy, const char* note);
/// How `pack` makes spheres.
void sphereOptions(OptionList& rows, PackRecipe& recipe);
void gapOption(OptionList& rows, double& gap, const char* help);
void densifyOption(OptionList& rows, double& fraction, const char* help);
/// Where `pack` and `densify` move spheres.
void deviceOption(OptionList& rows, DeviceChoice& device);
void densityOption(OptionList& rows, std::string& density);
void greyOptions(OptionList& rows, GreyRecipe& grey);
void bondOptions(OptionList& rows, BondOptions& bonds);
/// "E,NU". @throws ParameterError
std::pair<double, double> parseModulusAndPoisson(const std::string& text);
extern const char* const kRadiusSpec;

// void_options.cpp
/// What there is to cut: spheres while they are packed, an input pack, or none.
enum class VoidsIn { pack, file, nothing };
/// @param domain  that the shell lies in.
void voidOptions(OptionList& rows, VoidRequest& voids, DomainRecipe& domain, VoidsIn in);

// run_options.cpp
extern const char* const kPackHelp;
/// An input pack as the argument `name`, and what to compare it with.
/// @param domainShown  of the domain in the help.
void inputPackOptions(OptionList& rows, InputPack& input, const char* name, const std::string& help,
                      const char* domainShown = "DOMAIN");
/// How a pack of another program is read.
void packReadingOptions(OptionList& rows, Unit& unit, PackColumns& columns, double& radius,
                        const char* pack);
void packArgument(OptionList& rows, InputPack& input, const char* name, const std::string& help);
/// @param help  null: that of runs with spheres.
void outputOption(OptionList& rows, std::vector<OutputTarget>& outputs, const char* help = nullptr);
void imagesOption(OptionList& rows, bool& images);
void contactTolerance(OptionList& rows, double& tolerance);
void threadsOption(OptionList& rows, RunSettings& settings, const char* help = "number of threads");
void memoryLimit(OptionList& rows, RunSettings& settings);
void reportOption(OptionList& rows, RunSettings& settings, const char* help = nullptr);
void printing(OptionList& rows, PrintOptions& print, const char* json = nullptr);
/// Rows of all runs with one seed. @param random  what it decides: "of the voids".
void seedOption(OptionList& rows, RunSettings& settings, const char* random);
/// Rows of runs with one or several seeds. @param made  by each: "pack".
void studyOptions(OptionList& rows, Study& study, const std::string& made);
void cutAndColor(OptionList& rows, PreviewOptions& preview);
void previewOptions(OptionList& rows, PreviewOptions& preview);

/// The value of the option `columns` of a pack. @throws ParameterError
PackColumns parsePackColumns(const std::string& text);

}  // namespace vdbpack
