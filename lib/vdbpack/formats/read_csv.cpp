// Tables of any program: one row per sphere, columns by name.
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/text.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdbpack {

Pack<3> readCsv(const std::string& path, const PackReadOptions& options) {
    DelimitedText text(path);
    if (!options.columns.inOrder.empty())
        text.takeNames(options.columns.inOrder);
    else
        text.readHeader(
            "x,y,z,radius",
            ", name them with `columns` x,y,z,r, or read a list of x y z r as yade:FILE");
    TextTable table;
    table.names = text.names();
    table.options = options;
    if (PackBuilder(path, table.names, options).isFurther(0)) text.refuseAmbiguousComments();
    table.nextRow = [&text](Cells& cells) { return text.nextRow(cells); };
    return readTable(text.file(), table);
}

Pack<3> readTextFile(const std::string& path, const PackReadOptions& options) {
    constexpr std::pair<std::string_view, Pack<3> (*)(const std::string&, const PackReadOptions&)>
        kBeginnings[] = {{"#format", readYade},
                         {"##PERIODIC::", readYade},
                         {"Version ", readMfix},
                         {"ITEM:", readLammpsDump}};
    std::error_code none;
    if (std::filesystem::is_regular_file(path, none)) {  // what a pipe has comes once
        InputFile file(path);
        const std::string beginning(file.peek(16));
        for (const auto& [known, read] : kBeginnings)
            if (startsWith(beginning, known)) return read(path, options);
    }
    return readCsv(path, options);
}

}  // namespace vdbpack
