// A checksum by which packs are compared.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstdint>
#include <string>

namespace vdbpack {

/// A checksum of the spheres that does not depend on their order: the sum modulo 2^64 over all
/// spheres of a mix of the bits of x, y, z, r (double, mm; -0 counts as 0; 2D: z is `sliceHeight`).
///
/// For one sphere: h = 0x9e3779b97f4a7c15; for each v of x, y, z, r: h = mix(h ^ bits(v)); with
/// mix(h): h ^= h >> 30, h *= 0xbf58476d1ce4e5b9, h ^= h >> 27, h *= 0x94d049bb133111eb,
/// h ^= h >> 31, all modulo 2^64. (mix is the finalizer of SplitMix64.)
template <int Dim>
std::uint64_t packHash(const Pack<Dim>& pack);

/// 16 hexadecimal digits, as reports show a hash.
std::string hashText(std::uint64_t hash);

}  // namespace vdbpack
