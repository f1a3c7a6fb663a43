// Recipes: options of a command as TOML.
#include "cli/recipe.h"
#include "fuzz_file.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("r.toml");
    const std::string& path = file.write(data, size);
    // A command with each kind of option.
    CLI::App app("fuzz");
    app.name("vdb_pack");
    app.set_config("--config")->check(CLI::ExistingFile);
    app.config_formatter(std::make_shared<RecipeFormat>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();
    CLI::App* const pack = app.add_subcommand("pack");
    app.add_subcommand("voids");
    std::string radius, domain;
    std::vector<std::string> outputs;
    double fraction = 0;
    int threads = 0;
    bool quiet = false;
    pack->add_option("DOMAIN,--domain", domain);
    pack->add_option("-o,--out", outputs);
    pack->add_option("--radius", radius)->default_val("constant:1");
    pack->add_option("--void-fraction", fraction)->check(CLI::Range(0.0, 1.0));
    pack->add_option("--threads", threads);
    pack->add_flag("--quiet", quiet);
    const std::string words[] = {"vdb_pack", "pack", "--config", path};
    const char* arguments[] = {words[0].c_str(), words[1].c_str(), words[2].c_str(),
                               words[3].c_str()};
    try {
        app.parse(4, arguments);
        recipeText(*pack, "a/b");
    } catch (const CLI::ParseError& e) {
        if (*e.what() == '\0') fuzz::report("an error without a message");
    }
    return 0;
}
