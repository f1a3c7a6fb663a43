#include "vdbpack/voids/void_report.h"

namespace vdbpack {

std::string TargetReport::symbol() const {
    return name == "targetTbth"   ? "Tb.Th"
           : name == "targetTbsp" ? "Tb.Sp"
           : name == "targetDa"   ? "DA"
                                  : "Conn.D";
}

std::string TargetReport::unit() const {
    return name == "targetDa" ? "" : name == "targetConnd" ? " /mm³" : " mm";
}

}  // namespace vdbpack
