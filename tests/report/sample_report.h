// A report with the figures that every run on a mesh has.
#pragma once

#include "vdbpack/report/report.h"

namespace vdbpack::test {

inline Report sampleReport() {
    Report r;
    r.version = "1.2.3";
    r.task = "pack";
    r.command = "pack femur.ply -o femur.vdb";
    r.seed = 7;
    r.threads = 2;
    r.hash = 0xabc;
    r.domain.kind = "mesh";
    r.volume = 12340;
    r.count = 1101921;
    r.requested = "uniform:1,2";
    r.radius = {1, 1.5, 2, 0.29};
    r.ks = 0.004;
    r.ksByVolume = 0.005;
    r.solidFractionTotal = 0.586;
    r.solidFractionInterior = 0.62;
    r.massOffset = MassOffset{{0.3, std::nullopt, -0.4}, 0.5, 0.005};
    r.contacts.emplace();
    r.contacts->mean = 4.31;
    r.contacts->histogram = {1, 20, 300, 4000, 2000, 10};
    r.overlap = OverlapCheck{};
    r.protrusion = ProtrusionCheck{};
    r.seconds.pack = 10;
    r.seconds.total = 13.25;
    return r;
}

}  // namespace vdbpack::test
