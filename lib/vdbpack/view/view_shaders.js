// Coordinates of the camera: x right, y up, z out of the picture. Colors are sRGB, but linear while
// they are lit: squares and roots are near enough, and ten times as fast as powers in software.
const SHADER_HEAD = `#version 300 es
precision highp float;
uniform vec3 eye, right, up, toward;
uniform vec2 scale;   // tangents of half the angles of view
uniform vec2 range;   // nearest and farthest distance
uniform vec4 cut;     // normal and offset in coordinates of the camera; the kept side is >= 0
uniform float pixel;  // side of a pixel at distance 1
uniform bool plane;   // circles: only the face of the cut is seen
vec3 toCamera(vec3 d) { return vec3(dot(right, d), dot(up, d), dot(toward, d)); }
vec4 projected(vec3 p) {
  float w = -p.z, n = range.x, f = range.y;
  return vec4(p.xy / scale, ((f + n) * w - 2.0 * f * n) / (f - n), w);
}
`;

// Light as in pictures: a lamp at the upper left, the sky, a little from the camera.
const SHADER_LIGHT = `
vec3 display(vec3 c) { return sqrt(min(c, vec3(1.0))); }
const vec3 LAMP = vec3(-0.426401, 0.639602, 0.639602);
vec3 lit(vec3 albedo, vec3 n, vec3 back) {
  float facing = max(dot(n, back), 0.0);
  // The rims of spheres lie between others, where less of the sky is seen.
  float open = 0.45 + 0.55 * facing;
  float sky = 0.72 + 0.28 * dot(n, vec3(right.z, up.z, toward.z));
  float key = max(dot(n, LAMP), 0.0) * mix(0.75, 1.0, facing);
  float gloss = max(dot(n, normalize(back + LAMP)), 0.0);
  gloss *= gloss; gloss *= gloss; gloss *= gloss; gloss *= gloss; gloss *= gloss;  // power of 32
  return albedo * (0.62 * key + 0.56 * sky * open + 0.06 * facing) + 0.1 * gloss;
}
`;

// A sphere is a triangle around its outline. Points cost the same, have limits of size, and vanish
// where their centers leave the picture; software draws instances one by one.
const SPHERE_VERTEX = SHADER_HEAD + `
uniform highp sampler2D spheres, colors;
uniform int first, skip, chosen;
uniform float growth;  // of the radii
flat out vec4 ball;
flat out vec3 albedo;  // linear
void main() {
  int i = first + skip * (gl_VertexID / 3), k = gl_VertexID % 3;
  ivec2 place = ivec2(i & 2047, i >> 11);
  vec4 sphere = texelFetch(spheres, place, 0);
  albedo = i == chosen ? vec3(1.0, 0.18, 0.43) : texelFetch(colors, place, 0).rgb;
  albedo *= albedo;
  vec3 c = toCamera(sphere.xyz - eye);
  float r = growth * sphere.w, square = dot(c, c);
  ball = vec4(c, r);
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // out of sight
  if (dot(cut.xyz, c) + cut.w <= -r || square < 1.05 * r * r || c.z > r) return;
  // Corners of a triangle around the circle of radius 1.
  vec2 corner = vec2(k == 0 ? 0.0 : k == 1 ? -1.7320509 : 1.7320509, k == 0 ? 2.0 : -1.0);
  vec3 n = c * inversesqrt(square), across = normalize(cross(vec3(0.0, 1.0, 0.0), n));
  float reach = r * inversesqrt(1.0 - r * r / square);
  gl_Position = projected(c + reach * (corner.x * across + corner.y * cross(n, across)));
}
`;

const SPHERE_FRAGMENT = SHADER_HEAD + SHADER_LIGHT + `
flat in vec4 ball;
flat in vec3 albedo;
uniform vec2 size;  // of the picture, pixels
out vec4 shown;
const float RIM = 0.9, LARGEST_RIM = 0.14, RIM_SHADE = 0.5;  // pixels, share of the radius
void main() {
  vec3 c = ball.xyz, along = normalize(vec3((2.0 * gl_FragCoord.xy / size - 1.0) * scale, -1.0));
  float r = ball.w, middle = dot(c, along);
  vec3 off = c - along * middle;
  float square = r * r - dot(off, off);
  if (square < 0.0) discard;
  float enter = middle - sqrt(square), leave = middle + sqrt(square);
  vec3 p = along * enter, color = lit(albedo, (p - c) / r, -along);
  float beyond = dot(cut.xyz, p) + cut.w;
  if (beyond < 0.0) {
    // In front of the cut: seen is its face, if the ray meets that within the sphere.
    float slope = dot(cut.xyz, along), t = enter - beyond / slope;
    if (slope <= 0.0 || t > leave) discard;
    p = along * t;
    float height = dot(cut.xyz, c) + cut.w, width = pixel * -p.z;
    float rim = sqrt(max(r * r - height * height, 0.0)) - distance(p, c - cut.xyz * height);
    rim = (rim - min(RIM * width, LARGEST_RIM * r)) / width;
    color = albedo * 0.95 * mix(RIM_SHADE, 1.0, clamp(rim + 0.5, 0.0, 1.0));
  } else if (plane) {
    discard;
  }
  gl_FragDepth = 0.5 * (range.y + range.x + 2.0 * range.y * range.x / p.z) / (range.y - range.x) + 0.5;
  shown = vec4(display(color), 1.0);
}
`;

const WALL_VERTEX = SHADER_HEAD + `
layout(location = 0) in vec3 point;
out vec3 at;
void main() {
  at = toCamera(point - eye);
  gl_Position = projected(at);
}
`;

// The wall is a veil, thicker where it is seen edge-on; a cut draws a line on it. Of a solid it is
// opaque: where its inner side is seen, the cut has opened it, and shown is the face of the cut, which
// alpha 0 keeps from being shaded.
const WALL_FRAGMENT = SHADER_HEAD + SHADER_LIGHT + `
uniform vec3 bone, ink;
uniform float line;  // width of the line of the cut, pixels
uniform bool solid;
in vec3 at;
out vec4 shown;
void main() {
  vec3 back = -normalize(at), n = normalize(cross(dFdx(at), dFdy(at)));
  float edge = 1.0 - abs(dot(n, back)), side = dot(cut.xyz, at) + cut.w;
  if (solid) {
    shown = gl_FrontFacing ? vec4(display(lit(bone * bone, n, back)), 1.0) : vec4(0.9 * bone, 0.0);
    if (side < 0.0) discard;
    return;
  }
  shown = vec4(display(lit(bone * bone, n, back)), 0.05 + 0.5 * edge * edge * edge);
  if (plane || side < line * fwidth(side)) shown = vec4(ink, plane ? 1.0 : 0.9);
  if (!plane && side < 0.0) discard;
}
`;

const PRESENT_VERTEX = `#version 300 es
out vec2 place;
void main() {
  place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
  gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);
}
`;

// Shows the finished picture; darkens what lies between others that are nearer.
const PRESENT_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colors, depths;
uniform vec2 range;
uniform float reach;      // of the shade, as a share of the picture's height at distance 1
uniform float aspect;
uniform float radius;     // of what gives shade, mm
uniform bool plane;
in vec2 place;
out vec4 shown;
const float EDGE = 3.0;   // reach of the shade of edges, in that of the shade of neighbors
float distanceAt(vec2 x) {
  float z = 2.0 * texture(depths, x).r - 1.0, n = range.x, f = range.y;
  return 2.0 * f * n / (f + n - z * (f - n));
}
void main() {
  vec4 seen = texture(colors, place);
  vec3 color = seen.rgb;
  // Depths are read at the middles of their pixels: at edges between them rounding would decide.
  vec2 texel = 1.0 / vec2(textureSize(depths, 0)), here = (floor(place / texel) + 0.5) * texel;
  float own = distanceAt(here);
  if (!plane && seen.a > 0.5 && own < 0.999 * range.y) {
    // Each pixel turns the spiral of samples: what is left of it looks like fine grain.
    float turn = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    // Things count as nearer if they rise above the plane through the pixel's surface.
    vec2 across = vec2(texel.x, 0.0), along = vec2(0.0, texel.y);
    vec2 ahead = vec2(distanceAt(here + across), distanceAt(here + along)) - own;
    vec2 behind = own - vec2(distanceAt(here - across), distanceAt(here - along));
    vec2 slope = mix(behind, ahead, lessThan(abs(ahead), abs(behind))) / texel;
    float shade = 0.0, behindEdge = 0.0;
    const int SAMPLES = 16;
    for (int k = 0; k < SAMPLES; ++k) {
      float share = (float(k) + 0.5) / float(SAMPLES);
      float angle = 2.3999632 * (float(k) + turn);  // the golden angle
      vec2 off = vec2(cos(angle) * aspect, sin(angle)) * sqrt(share) * reach / own;
      // Near outlines the plane is steep, and tells little.
      float rise = clamp(dot(slope, off), -radius, radius);
      float above = (own + rise - distanceAt(here + off)) / radius;
      // Shade from things within a few radii; what lies far in front gives none.
      shade += clamp(above - 0.3, 0.0, 1.0) * (1.0 - smoothstep(2.0, 6.0, above));
      // What lies behind an edge is darker there, which sets off the parts of a bone from each other
      // (Luft, Colditz, Deussen 2006, doi:10.1145/1141911.1142016).
      if (k % 2 == 0) continue;
      off *= EDGE;
      rise = clamp(dot(slope, off), -2.0 * radius, 2.0 * radius);
      behindEdge += smoothstep(3.0, 12.0, (own + rise - distanceAt(here + off)) / radius);
    }
    color *= 1.0 - 0.6 * smoothstep(0.05, 0.9, shade / float(SAMPLES));
    color *= 1.0 - 0.55 * smoothstep(0.0, 0.8, behindEdge / float(SAMPLES / 2));
  }
  shown = vec4(color, 1.0);
}
`;
