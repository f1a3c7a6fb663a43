#include "vdbpack/distributed/rank_outputs.h"

namespace vdbpack {

template <int Dim>
std::vector<std::string> writeOverRanks(const std::vector<OutputTarget>& outputs,
                                        const RunOutputs<Dim>& have, const PackShare<Dim>& share,
                                        const Callbacks& callbacks) {
    Ranks& ranks = *share.ranks;
    std::vector<std::string> files;
    for (const OutputTarget& output : outputs) {
        callbacks.report("write", 0, 0);
        std::vector<std::string> written{output.file};
        // All have the level sets and the voids.
        if (output.kind == OutputKind::pack)
            written = writeShare(share, output.text, have.options);
        else if (ranks.isFirst())
            written = writeOutput(output, have);
        files.insert(files.end(), written.begin(), written.end());
    }
    anyOver(&ranks, false);  // all files are there
    return files;
}

template std::vector<std::string> writeOverRanks(const std::vector<OutputTarget>&,
                                                 const RunOutputs<2>&, const PackShare<2>&,
                                                 const Callbacks&);
template std::vector<std::string> writeOverRanks(const std::vector<OutputTarget>&,
                                                 const RunOutputs<3>&, const PackShare<3>&,
                                                 const Callbacks&);

}  // namespace vdbpack
