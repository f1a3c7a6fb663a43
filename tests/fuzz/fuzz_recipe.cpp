// Recipes: options of a command as TOML.
#include "fuzz_file.h"

#include "vdbpack/options/recipe_toml.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("r.toml");
    const std::string& path = file.write(data, size);
    // A command with each kind of option.
    CLI::App app("fuzz");
    app.name("vdb_pack");
    app.set_config("--config")->check(CLI::ExistingFile);
    app.config_formatter(std::make_shared<RecipeFormat>(app, [](const std::string& option) {
        return option == "output" ? FileIn::output : FileIn::domain;
    }));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();
    CLI::App* const pack = app.add_subcommand("pack");
    app.add_subcommand("voids");
    std::string radius, domain;
    std::vector<std::string> outputs;
    std::optional<double> fraction;
    bool connected = false;
    OptionList rows;
    rows.text("domain", "", domain, "").naming(FileIn::domain);
    rows.texts("output", "", outputs, "").naming(FileIn::output);
    rows.text("radius", "", radius, "").naming(FileIn::sizes);
    rows.number("target-bvtv", "", fraction, Range::notNegative, "");
    rows.flag("keep-connected", connected, "");
    const auto options = rows.take();
    pack->add_option("--domain", domain);
    pack->add_option("--output", outputs);
    pack->add_option("--radius", radius);
    pack->add_option("--target-bvtv", fraction);
    pack->add_flag("--keep-connected", connected);
    const std::string words[] = {"vdb_pack", "pack", "--config", path};
    const char* arguments[] = {words[0].c_str(), words[1].c_str(), words[2].c_str(),
                               words[3].c_str()};
    try {
        app.parse(4, arguments);
        recipeText(*pack, options, "a/b");
    } catch (const CLI::ParseError& e) {
        if (*e.what() == '\0') fuzz::report("an error without a message");
    }
    return 0;
}
