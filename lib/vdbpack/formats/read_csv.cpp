// Tables of any program: one row per sphere, columns by name.
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/delimited_text.h"

#include <string>

namespace vdbpack {

Pack<3> readCsv(const std::string& path, const PackReadOptions& options) {
    DelimitedText text(path);
    text.readHeader("x,y,z,radius", ", or read a list of x y z r as yade:FILE");
    TextTable table;
    table.names = text.names();
    table.unit = options.unit;
    if (PackBuilder(path, table.names, options.unit).isFurther(0)) text.refuseAmbiguousComments();
    table.nextRow = [&text](Cells& cells) { return text.nextRow(cells); };
    return readTable(text.file(), table);
}

}  // namespace vdbpack
