#include "bones.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

using V = Vec<3>;

const V kX{{1, 0, 0}};
const V kY{{0, 1, 0}};
const V kZ{{0, 0, 1}};

// One tooth: a crown narrow at its neck, on a root hidden in the jaw.
struct Tooth {
    V neck;         // middle of the crown's base, mm
    V outward;      // from the tongue to the lips or cheek
    double width;   // along the row, half, mm
    double depth;   // across the row, half, mm
    double height;  // of the crown, mm
    bool grinding;  // molars and premolars: a flat crown with cusps
};

// `up` is +1 in the lower jaw, -1 in the upper.
void addTooth(Sculpture& s, const Tooth& t, double up) {
    const V axis = up * kZ;
    const V along = normalized(cross(t.outward, kZ));
    const double w = t.width, d = t.depth, h = t.height;
    if (t.grinding) {
        s.add(tube({{t.neck - 5.0 * axis, 0.9 * w, 0.8 * d, along},
                    {t.neck, 0.98 * w, 0.9 * d, along},
                    {t.neck + 0.4 * h * axis, 1.02 * w, d, along},
                    {t.neck + 0.6 * h * axis, 0.95 * w, 0.88 * d, along}},
                   Profile::kStadium),
              1.2);
        const double r = 0.42 * std::min(w, d);
        const V top = t.neck + (h - r) * axis;
        const bool molar = w > 4;
        for (const double sideways : {-1.0, 1.0})
            for (const double lengthwise : {-1.0, 1.0}) {
                if (!molar && lengthwise > 0) continue;
                const V shift = sideways * (d - 1.25 * r) * t.outward +
                                (molar ? lengthwise * (w - 1.3 * r) : 0.0) * along;
                s.add(ellipsoid(top + shift, {{r, r, r}}), 1.8);
            }
    } else {
        // Incisors and canines: a blade, leaning outward.
        const V lean = 0.12 * h * t.outward;
        s.add(tube({{t.neck - 5.0 * axis - lean, 0.9 * w, 0.8 * d, along},
                    {t.neck, w, 0.9 * d, along},
                    {t.neck + 0.5 * h * axis + 0.6 * lean, 1.03 * w, 0.66 * d, along},
                    {t.neck + 0.86 * h * axis + lean, 0.9 * w, 0.34 * d, along}}),
              1.0);
    }
}

}  // namespace

Sculpture femur() {
    Sculpture s;
    // The mechanical axis, from the head's center to the middle of the knee, is the z axis.
    const V head{{0, -8, 406}};
    // Shaft, bowed forward, falling towards the middle of the body.
    s.add(tube({{{{-46, 2, 372}}, 15.5, 14.5},
                {{{-45, 0, 345}}, 16.5, 15},
                {{{-40, -4, 300}}, 15, 14.6},
                {{{-33, -8.5, 240}}, 13.9, 14},
                {{{-24, -9, 175}}, 14, 14.2},
                {{{-14, -5, 115}}, 16, 14.5},
                {{{-7, -1, 75}}, 20, 15},
                {{{-2, 2, 45}}, 27, 18}}),
          0);
    // The rough line along its back.
    s.add(roundTube({{{{-44, 9, 330}}, 4.5},
                     {{{-37, 5.5, 280}}, 5},
                     {{{-29, 1.6, 215}}, 5.2},
                     {{{-20, 2, 155}}, 5},
                     {{{-13, 4.5, 115}}, 4}}),
          9);
    // Neck and head.
    s.add(tube({{{{-50, 3, 358}}, 19, 14, {{-0.7, 0, 0.7}}},
                {{{-34, -2, 377}}, 17.5, 13, {{-0.6, 0, 0.8}}},
                {{{-19, -5, 393}}, 15.5, 14, {{-0.6, 0, 0.8}}},
                {{{-6, -7, 402}}, 17, 17, {{-0.6, 0, 0.8}}}}),
          14);
    s.add(ellipsoid(head, {{23.5, 23.5, 23.5}}), 5);
    s.cut(ellipsoid(head + V{{22.5, 4, 7}}, {{3, 5, 5}}), 3);
    // Greater trochanter: a block with a blunt upper edge that overhangs the pit behind the neck.
    s.add(tube({{{{-60, 4, 352}}, 15, 9, kY},
                {{{-61, 4, 375}}, 20, 11, kY},
                {{{-59, 6, 394}}, 18, 11, kY},
                {{{-56, 9, 401}}, 14, 10, kY}}),
          12);
    s.cut(ellipsoid({{-40, 20, 392}}, {{8, 7, 10}}), 9);
    // Crest between the trochanters, along the back.
    s.add(roundTube({{{{-54, 14, 392}}, 6}, {{{-46, 17, 372}}, 5}, {{{-36, 15, 350}}, 5.5}}), 10);
    // Lesser trochanter.
    s.add(roundTube({{{{-38, 8, 343}}, 10}, {{{-27, 15, 346}}, 6.5}}), 12);
    // Flare above the knee.
    s.add(tube({{{{-15, -3, 122}}, 6, 5, kX},
                {{{-7, 0, 78}}, 20, 13.5, kX},
                {{{-2, 3, 48}}, 33, 19, kX},
                {{{0, 5, 34}}, 35, 21, kX}}),
          14);
    // Condyles: rolls that turn from below to the back. The inner one reaches further back.
    s.add(tube({{{{-19, -9, 31}}, 15, 21},
                {{{-22, 3, 22.5}}, 16.5, 22},
                {{{-23, 18, 24}}, 16, 22},
                {{{-22, 24, 33}}, 15.5, 18},
                {{{-20, 14, 47}}, 14, 12}}),
          8);
    s.add(tube({{{{18, -6, 30}}, 14, 19},
                {{{21, 4, 22}}, 16, 22},
                {{{23, 19, 23.5}}, 16.5, 23},
                {{{23, 27, 33}}, 16, 18},
                {{{20, 15, 48}}, 14, 12}}),
          8);
    // Epicondyles.
    s.add(ellipsoid({{-35, 8, 36}}, {{7, 13, 13}}), 12);
    s.add(ellipsoid({{35, 9, 39}}, {{8, 14, 16}}), 14);
    // The notch between them, and the shallow groove for the kneecap in front.
    s.cut(tube({{{{1, 66, 22}}, 10, 28},
                {{{1, 38, 14}}, 8.5, 24},
                {{{0, 20, 4}}, 7.5, 13},
                {{{0, 11, -6}}, 6, 8}}),
          6);
    s.cut(roundTube({{{{-3, -62, 60}}, 25},
                     {{{-3, -51, 34}}, 23.5},
                     {{{-2, -34, 4}}, 21},
                     {{{-1, -16, -15}}, 17}}),
          10);
    // The flat triangle behind, above the notch.
    s.cut(ellipsoid({{-3, 41, 84}}, {{22, 22, 34}}), 12);
    return s;
}

Sculpture mandible() {
    Sculpture s(true);
    // Body: a strip on edge, bent to a horseshoe; its lower border lies further out behind.
    s.add(tube({{{{0, -43, 14}}, 14.5, 6.2, {{0, -0.12, 1}}},
                {{{11, -41, 14}}, 14.5, 6, {{0, -0.1, 1}}},
                {{{21, -33, 13.5}}, 14, 5.6, {{-0.1, 0, 1}}},
                {{{28, -20, 13.5}}, 13.5, 5.6, {{-0.22, 0, 1}}},
                {{{34, -4, 14}}, 13.5, 6, {{-0.36, 0, 1}}},
                {{{40, 12, 16}}, 13, 5.2, {{-0.3, 0, 1}}},
                {{{43.5, 24, 18}}, 12, 4, {{-0.12, 0, 1}}}},
               Profile::kStadium),
          0);
    // The ridge that carries the teeth.
    s.add(tube({{{{0, -43.5, 26}}, 6, 4.6, {{0, 0, 1}}},
                {{{8, -42, 26}}, 6, 4.6, {{0, 0, 1}}},
                {{{15.5, -36.5, 26}}, 6, 4.8, {{0, 0, 1}}},
                {{{20.5, -27, 26}}, 6, 5.2, {{0, 0, 1}}},
                {{{24.5, -14, 26}}, 6, 6, {{0, 0, 1}}},
                {{{28, 0, 26.5}}, 6, 6, {{0, 0, 1}}},
                {{{31, 8, 28}}, 4.5, 4.5, {{0, 0, 1}}}},
               Profile::kStadium),
          5);
    // Chin.
    s.add(ellipsoid({{0, -47, 6}}, {{8, 6, 7}}), 10);
    s.add(ellipsoid({{9, -45, 3.5}}, {{6, 5, 4.5}}), 8);
    // Rami, leaning back.
    s.add(plate({{{0, 0, 0}},
                 {kY, kZ, kX},
                 {{28, 2},  {36, 10},   {39, 23}, {39.5, 38}, {41, 52},   {44, 64},  {43, 71},
                  {36, 71}, {32.5, 62}, {27, 54}, {19, 52},   {12.5, 57}, {8, 65.5}, {3, 64.5},
                  {1, 54},  {3, 42},    {2, 30},  {-4, 20},   {-4, 8},    {10, 0}},
                 [](double u, double v) {
                     return 43 + 0.05 * (v - 20) + 0.0008 * (v - 30) * (v - 30) -
                            0.002 * (u - 20) * (u - 20);
                 },
                 [](double u, double v) { return 4.2 - 0.02 * (u - 20) - 0.012 * (v - 30); }}),
          7);
    // The oblique line runs from the front edge of the ramus down onto the body.
    s.add(roundTube({{{{43.5, 6, 48}}, 2.5},
                     {{{42, 4.5, 37}}, 3.6},
                     {{{39, -1, 26}}, 4},
                     {{{34.5, -12, 18}}, 4},
                     {{{29.5, -22, 13}}, 4}}),
          8);
    // Angle of the jaw, slightly turned out.
    s.add(roundTube({{{{42, 12, 3}}, 3.6}, {{{45.5, 26, 6.5}}, 4.2}, {{{46.5, 34.5, 17}}, 3.4}}),
          8);
    // Condyles: rolls across the neck, inner end further back.
    s.add(roundTube({{{{42, 41, 72}}, 4.2}, {{{48, 40, 73.5}}, 5.2}, {{{54.5, 38.5, 72}}, 4.2}}),
          8);
    s.add(tube({{{{45, 33, 44}}, 3, 3, kX}, {{{47.5, 39.5, 66}}, 5.5, 4.5, kX}}), 8);
    // Mental foramen.
    s.cut(ellipsoid({{27.5, -32.5, 14}}, {{3.5, 2.5, 2}}), 1.5);

    const double z = 32;
    for (const Tooth& t :
         std::vector<Tooth>{{{{2.9, -44.5, z}}, {{0.08, -1, 0}}, 2.7, 3.0, 9.0, false},
                            {{{8.4, -43.2, z}}, {{0.3, -0.95, 0}}, 3.0, 3.1, 9.0, false},
                            {{{13.8, -39.2, z}}, {{0.65, -0.76, 0}}, 3.5, 3.8, 10.0, false},
                            {{{17.8, -33.2, z}}, {{0.88, -0.48, 0}}, 3.6, 3.9, 8.6, true},
                            {{{20.4, -26.3, z}}, {{0.94, -0.34, 0}}, 3.7, 4.1, 8.2, true},
                            {{{23.3, -17.2, z}}, {{0.95, -0.3, 0}}, 5.7, 5.2, 7.8, true},
                            {{{26.3, -6.0, z}}, {{0.96, -0.27, 0}}, 5.6, 5.1, 7.5, true},
                            {{{28.9, 4.6, z + 0.5}}, {{0.97, -0.24, 0}}, 5.1, 4.8, 7.0, true}})
        addTooth(s, t, +1);
    return s;
}

namespace {

/// The wing of the ilium, a plate: u runs backward and towards the spine, v up; the normal faces
/// forward and inward.
struct Wing {
    Frame frame{{{0.5, 0.8660254037844386, 0}}, {{-0.0, 0, 1}}, {{0.8660254037844386, -0.5, 0}}};
    V origin{{5, 5, 0}};

    /// Seen from above the wing is an S: hollow on the inside in front (the iliac fossa), bent the
    /// other way at the joint with the sacrum; upward it leans out.
    static double height(double u, double v) {
        const double t = (u - 20) / 80;
        const double lift = v > 0 ? v * v / (v * v + 60 * 60) : 0.0;
        return (-22 + 28 * t * t + 14 * t) * lift - 3;
    }
    V at(double u, double v) const {
        return origin + u * frame.x + v * frame.y + height(u, v) * frame.z;
    }
};

void addWing(Sculpture& s, const Wing& wing) {
    s.add(plate({wing.origin,
                 wing.frame,
                 {{-58, 86}, {-50, 104}, {-30, 120}, {0, 130},  {32, 129}, {62, 117}, {86, 98},
                  {98, 79},  {95, 61},   {80, 52},   {62, 49},  {46, 44},  {38, 30},  {37, 5},
                  {30, -18}, {0, -22},   {-18, -8},  {-24, 18}, {-31, 40}, {-44, 62}},
                 Wing::height,
                 [](double u, double v) {
                     // Thinnest in the middle of the fossa, thick towards the socket.
                     const double a = (u + 2) * (u + 2) / 5200 + (v - 88) * (v - 88) / 3600;
                     const double b = v < 52 ? (52 - v) / 52 : 0.0;
                     return 2.7 + 3.6 * a / (1 + a) + 4.5 * b * b;
                 }}),
          0);
    // Crest, thickest at the tubercle.
    {
        std::vector<Bead> crest;
        const double uvr[][3] = {{-54, 86, 5.5}, {-47, 100, 5.2}, {-31, 114, 7}, {-8, 123, 6},
                                 {14, 126, 5},   {36, 122, 5.2},  {60, 112, 6},  {80, 95, 7},
                                 {91, 78, 7},    {88, 65, 6}};
        for (const auto& c : uvr) crest.push_back({wing.at(c[0], c[1]), c[2]});
        s.add(roundTube(crest), 8);
    }
    // Front edge with its two spines.
    s.add(ellipsoid(wing.at(-55, 84), {{6, 6, 8}}), 6);
    s.add(roundTube({{wing.at(-47, 70), 4.2},
                     {wing.at(-37, 52), 4.8},
                     {wing.at(-28, 36), 8.5},
                     {wing.at(-20, 14), 9}}),
          9);
    // Joint with the sacrum: a thick ear-shaped area behind, on the inside.
    s.add(tube({{wing.at(58, 54) + 4.0 * wing.frame.z, 9, 7, wing.frame.y},
                {wing.at(66, 70) + 5.0 * wing.frame.z, 13, 9, wing.frame.y},
                {wing.at(80, 80) + 4.0 * wing.frame.z, 12, 8, wing.frame.y}}),
          12);
}

void addSocket(Sculpture& s, const V& facing, const Frame& cup) {
    s.add(ellipsoid(-11.0 * facing, {{35, 35, 25}}, cup), 14);
    // Its rim, open below.
    {
        const Vec<3> right = cup.y, up = cup.x;
        const double around[][2] = {{-0.85, -0.75}, {-1, -0.4}, {-1, 0.3}, {-0.6, 0.9}, {0, 1},
                                    {0.6, 0.9},     {1, 0.3},   {1, -0.4}, {0.9, -0.7}};
        std::vector<Bead> rim;
        for (const auto& a : around)
            rim.push_back({5.0 * facing + 29.0 * normalized(a[0] * right + a[1] * up), 3.6});
        s.add(roundTube(rim), 7);
    }
}

void addIschiumAndPubis(Sculpture& s) {
    // Ischium down to the tuberosity, and its branch to the pubis.
    s.add(tube({{{{16, 26, 22}}, 12, 15, kX},
                {{{18, 27, -10}}, 13, 17, kX},
                {{{17, 30, -38}}, 12, 14, kX},
                {{{15, 29, -56}}, 13, 17, kX},
                {{{19, 22, -65}}, 11, 14, kX}}),
          14);
    s.add(tube({{{{16, 24, -60}}, 10, 9, {{0.6, 0.5, 0.6}}},
                {{{24, 14, -68}}, 10, 8.5, {{0.6, 0.3, 0.7}}},
                {{{38, -1, -67}}, 9.5, 6.5, {{0.6, 0.2, 0.75}}},
                {{{54, -18, -56}}, 9.5, 6, {{0.6, 0.2, 0.75}}},
                {{{68, -33, -42}}, 12, 6.5, {{0.6, 0.1, 0.75}}},
                {{{74, -40, -28}}, 13, 7, {{0.7, 0.1, 0.6}}}}),
          14);
    // Spine of the ischium.
    s.add(roundTube({{{{22, 36, -12}}, 8}, {{{30, 44, -18}}, 4.5}, {{{35, 48, -20}}, 3}}), 10);
    // Pubis with the face of the symphysis.
    s.add(tube({{{{72, -43, -13}}, 10, 8, {{0.5, 0.8, 0}}},
                {{{76, -43, -27}}, 11, 7.5, {{0.6, 0.8, 0}}},
                {{{75, -40, -42}}, 9, 6.5, {{0.6, 0.8, 0}}}}),
          10);
    s.add(ellipsoid({{66, -48, -7}}, {{6, 5, 5}}), 8);
}

/// The cavity of the joint.
void cutSocket(Sculpture& s, const V& facing, const Frame& cup) {
    // With its rough floor and the gap in the lower rim.
    s.cut(ellipsoid({{0, 0, 0}}, {{26.5, 26.5, 26.5}}), 2.5);
    const V down = normalized(-1.0 * (kZ - facing * dot(kZ, facing)) - 0.25 * kY);
    s.cut(ellipsoid(-13.0 * facing + 3.0 * down, {{15, 15, 15.5}}, cup), 3);
    s.cut(roundTube({{-10.0 * facing + 8.0 * down, 11},
                     {-3.0 * facing + 24.0 * down, 10},
                     {6.0 * facing + 42.0 * down, 11}}),
          7);
}

}  // namespace

Sculpture hip() {
    Sculpture s;
    // The middle of the socket is the origin.
    const Wing wing;
    const V facing = normalized(V{{-0.78, -0.3, -0.55}});
    const Frame cup = Frame::of(facing, kZ);
    addWing(s, wing);
    // Brim of the pelvis, from that joint to the pubis.
    s.add(roundTube({{wing.at(52, 52) + 3.0 * wing.frame.z, 8},
                     {{{28, 30, 30}}, 9.5},
                     {{{22, 8, 14}}, 12},
                     {{{26, -16, 4}}, 11.5},
                     {{{46, -33, 0}}, 9.5},
                     {{{66, -42, -9}}, 9.5}}),
          14);
    addSocket(s, facing, cup);
    addIschiumAndPubis(s);
    cutSocket(s, facing, cup);
    return s;
}

namespace {

/// The right orbit: its apex, the middle of its opening, and the frame with z from one to the
/// other.
struct Orbit {
    V apex{{12, -34, -10}};
    V socket{{31, -74, -7}};
    Frame gaze = Frame::of(socket - apex, kX);
};

/// The cavity of the brain: the vault minus its wall and minus the bone of the base.
std::shared_ptr<Sculpture> brainCavity(const std::shared_ptr<Sculpture>& vault,
                                       const Orbit& orbit) {
    const auto& [apex, socket, gaze] = orbit;
    auto cavity = std::make_shared<Sculpture>(true);
    cavity->add(insetOf(vault, 6.0), 0);
    // Roofs of the orbits, and the middle of the base.
    cavity->cut(tube({{socket - 12.0 * gaze.z, 26, 24, gaze.x}, {apex, 15, 14, gaze.x}}), 8);
    cavity->cut(roundTube({{{{0, -90, -16}}, 20},
                           {{{0, -50, -15}}, 19},
                           {{{0, -18, -24}}, 13},
                           {{{0, 2, -44}}, 12}}),
                8);
    cavity->cut(roundTube({{{{12, -4, -38}}, 9}, {{{34, 4, -30}}, 9}, {{{56, 14, -24}}, 8}}), 8);

    return cavity;
}

void addFace(Sculpture& s, const Orbit& orbit) {
    const auto& [apex, socket, gaze] = orbit;
    // Face: the block between the orbits and the teeth.
    s.add(tube({{{{0, -58, -14}}, 20, 26, kX},
                {{{0, -63, -38}}, 31, 21, kX},
                {{{0, -65, -54}}, 28, 20, kX}}),
          10);
    // Brows and the root of the nose.
    s.add(roundTube({{{{0, -84, 9}}, 6.5},
                     {{{15, -83, 12}}, 6.5},
                     {{{32, -77, 13}}, 6},
                     {{{46, -66, 6}}, 6},
                     {{{50, -62, -5}}, 5.5}}),
          9);
    s.add(tube({{{{0, -82, 4}}, 8, 7, kX},
                {{{0, -86, -8}}, 6.5, 5, kX},
                {{{0, -93, -20}}, 5.8, 3.6, kX}}),
          7);
    // Hollow of the temple.
    s.cut(ellipsoid({{68, -46, -8}}, {{20, 22, 27}}), 12);
    // The orbits' walls towards the temples.
    s.add(tube({{socket - 8.0 * gaze.z, 23, 21, gaze.x},
                {socket - 24.0 * gaze.z, 19, 17, gaze.x},
                {apex, 9, 9, gaze.x}}),
          6);
    // Cheek bones and arches.
    s.add(roundTube({{{{50, -63, -2}}, 5.5},
                     {{{51, -61, -16}}, 6},
                     {{{50, -62, -29}}, 8.5},
                     {{{37, -70, -36}}, 10},
                     {{{27, -71, -46}}, 8}}),
          8);
    s.add(roundTube({{{{14, -80, -22}}, 4.5},
                     {{{28, -79, -26}}, 5},
                     {{{42, -74, -25}}, 5.5},
                     {{{51, -64, -18}}, 5}}),
          6);
    s.add(tube({{{{49, -60, -28}}, 8, 5, kZ},
                {{{57, -48, -30}}, 7, 4, kZ},
                {{{63, -30, -29}}, 5.2, 3.6, kZ},
                {{{65, -10, -26}}, 5, 3.6, kZ},
                {{{61, 6, -23}}, 6.5, 5, kZ},
                {{{56, 16, -20}}, 7, 5, kZ}}),
          7);
    // Upper jaw.
    s.add(tube({{{{0, -82, -57}}, 8, 5.5, kZ},
                {{{10, -79, -57}}, 8, 5.5, kZ},
                {{{18, -72, -57}}, 8, 5.5, kZ},
                {{{24, -60, -57}}, 8, 6, kZ},
                {{{28, -46, -56}}, 8, 6, kZ},
                {{{29, -38, -55}}, 7, 5, kZ}},
               Profile::kStadium),
          11);
    s.add(ellipsoid({{0, -85, -47}}, {{3, 6, 3.5}}), 5);
    s.cut(ellipsoid({{0, -54, -69}}, {{17, 27, 12}}), 4);
    // Wings behind the palate.
    s.add(tube({{{{17, -30, -22}}, 5, 9, kX},
                {{{17, -30, -42}}, 4, 7, kX},
                {{{18, -29, -57}}, 3, 4, kX}}),
          8);
}

void addProcesses(Sculpture& s) {
    // Temporal and occipital processes.
    s.add(roundTube({{{{53, 20, -22}}, 16}, {{{53, 20, -38}}, 12}, {{{50, 17, -51}}, 7}}), 12);
    s.add(roundTube({{{{12, 12, -44}}, 5}, {{{17, 22, -44}}, 5}}), 6);
    s.add(roundTube({{{{0, 87, -8}}, 5},
                     {{{16, 84, -10}}, 4.5},
                     {{{38, 70, -15}}, 4},
                     {{{50, 50, -20}}, 4}}),
          12);
    s.cut(ellipsoid({{68, 8, -29}}, {{14, 3.4, 4.2}}), 3);
}

void cutOpenings(Sculpture& s, const Orbit& orbit) {
    const auto& [apex, socket, gaze] = orbit;
    // Orbits.
    s.cut(tube({{socket + 20.0 * gaze.z, 20, 16, gaze.x},
                {socket - 4.0 * gaze.z, 19, 15.8, gaze.x},
                {socket - 22.0 * gaze.z, 14, 13, gaze.x},
                {apex + 4.0 * gaze.z, 4, 4, gaze.x}}),
          5);
    // Nose: a pear-shaped opening, the cavity behind it, and the septum in its middle.
    s.cut(tube({{{{0, -104, -20}}, 5, 9, kX},
                {{{0, -86, -31}}, 9, 13, kX},
                {{{0, -62, -33}}, 10.5, 13, kX},
                {{{0, -16, -40}}, 10, 9, kX}}),
          3);
    s.cut(ellipsoid({{7, -88, -40}}, {{6.5, 16, 6.5}}), 4);
    s.add(
        plate({{{0, 0, 0}},
               {kY, kZ, kX},
               {{-80, -24}, {-74, -38}, {-76, -52}, {-40, -52}, {-30, -46}, {-32, -20}, {-60, -12}},
               [](double, double) { return 0.0; },
               [](double, double) { return 1.9; }}),
        3);
    // The way out for the spinal cord.
    s.cut(tube({{{{0, 24, -22}}, 14, 17, kX}, {{{0, 26, -66}}, 14.5, 17.5, kX}}), 4);
}

void addUpperTeeth(Sculpture& s) {
    const double z = -64;
    for (const Tooth& t :
         std::vector<Tooth>{{{{4.1, -83.5, z}}, {{0.1, -1, 0}}, 4.1, 3.4, 10.5, false},
                            {{{11.2, -80.6, z}}, {{0.42, -0.9, 0}}, 3.3, 3.2, 9.6, false},
                            {{{16.8, -75.6, z}}, {{0.75, -0.66, 0}}, 3.7, 3.9, 10.4, false},
                            {{{20.4, -69.0, z}}, {{0.9, -0.43, 0}}, 3.5, 4.4, 8.6, true},
                            {{{22.9, -62.3, z}}, {{0.95, -0.3, 0}}, 3.5, 4.4, 8.2, true},
                            {{{25.4, -53.2, z}}, {{0.96, -0.26, 0}}, 5.3, 5.3, 7.8, true},
                            {{{28.0, -43.0, z}}, {{0.97, -0.22, 0}}, 5.1, 5.2, 7.4, true}})
        addTooth(s, t, -1);
}

}  // namespace

Sculpture skull() {
    // Heights: the lower rim of the orbits and the ear canal lie at z = -24.
    auto vault = std::make_shared<Sculpture>(true);
    vault->add(ellipsoid({{0, 19, 24}}, {{69, 70, 67}}), 0);
    vault->add(ellipsoid({{0, -31, 31}}, {{50, 54, 52}}), 28);
    vault->add(ellipsoid({{0, 48, -2}}, {{52, 41, 40}}), 24);
    vault->add(ellipsoid({{0, 8, -13}}, {{58, 54, 33}}), 22);

    const Orbit orbit;
    const auto cavity = brainCavity(vault, orbit);

    Sculpture s(true);
    s.add(insetOf(vault, 0), 0);
    addFace(s, orbit);
    addProcesses(s);
    s.cut(insetOf(cavity, 0), 2);
    cutOpenings(s, orbit);
    addUpperTeeth(s);
    return s;
}

}  // namespace vdbpack
