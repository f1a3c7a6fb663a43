// Coordinates of the camera: x right, y up, z out of the picture. Colors are sRGB, but linear while
// they are lit: squares and roots are near enough, and ten times as fast as powers in software.
// Kinds of programs are chosen by macros: PLANE (looked at from above, without perspective), CUT,
// POINTS (or triangles), ROUGH (points while the scene moves). Branches cost both ways in software.
const SHADER_HEAD = `
precision highp float;
uniform vec3 eye, right, up, toward;
uniform vec2 scale;        // in space: tangents of half the angles of view; else half the sides, mm
uniform vec2 range;        // nearest and farthest distance
uniform vec4 cut;          // normal and offset in coordinates of the camera; the kept side is >= 0
uniform float pixel;       // side of a pixel: at distance 1, in the plane in mm
vec3 toCamera(vec3 d) { return vec3(dot(right, d), dot(up, d), dot(toward, d)); }
vec4 projected(vec3 p) {
#ifdef PLANE
  return vec4(p.xy / scale, 0.0, 1.0);
#else
  float w = -p.z, n = range.x, f = range.y;
  return vec4(p.xy / scale, ((f + n) * w - 2.0 * f * n) / (f - n), w);
#endif
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

// A sphere is a point that covers its outline, or where that is large or leaves the picture a
// triangle (points have limits). Nothing is drawn by instances, which software draws one by one.
const SPHERE_VERTEX = SHADER_HEAD + `
uniform highp sampler2D spheres, colors;
uniform int first, skip;
flat out float share;  // of a point's side, to the diameter of the sphere
flat out vec4 ball;
flat out vec3 albedo;  // linear
void main() {
#ifdef POINTS
  int i = first + skip * gl_VertexID;
#else
  int i = first + skip * (gl_VertexID / 3);
#endif
  ivec2 place = ivec2(i & 2047, i >> 11);
  vec4 sphere = texelFetch(spheres, place, 0);
  albedo = texelFetch(colors, place, 0).rgb;
  albedo *= albedo;
  vec3 c = toCamera(sphere.xyz - eye);
  float r = sphere.w, square = dot(c, c);
  ball = vec4(c, r);
  share = 1.0;
  gl_PointSize = 1.0;
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // out of sight
#ifdef CUT
  if (dot(cut.xyz, c) + cut.w <= -r) return;
#endif
#ifdef PLANE
  float side = 2.0 * r / pixel;
#else
  if (square < 1.05 * r * r || c.z > r) return;
  float side = 2.0 * r / pixel * inversesqrt(square - r * r);
#endif
#ifdef POINTS
  gl_Position = projected(c);
#if defined(PLANE) || defined(ROUGH)
  gl_PointSize = 0.5 + side;
#else
  gl_PointSize = 0.5 + 1.12 * side;  // off the middle of the picture outlines are longer
#endif
  share = gl_PointSize / side;
#else
  int k = gl_VertexID % 3;  // corners of a triangle around the circle of radius 1
  vec2 corner = vec2(k == 0 ? 0.0 : k == 1 ? -1.7320509 : 1.7320509, k == 0 ? 2.0 : -1.0);
#ifdef PLANE
  gl_Position = projected(c + vec3(corner * r, 0.0));
#else
  vec3 n = c * inversesqrt(square);
  vec3 across = normalize(cross(vec3(0.0, 1.0, 0.0), n));
  float reach = r * sqrt(square / (square - r * r));
  gl_Position = projected(c + reach * (corner.x * across + corner.y * cross(n, across)));
#endif
#endif
}
`;

const SPHERE_FRAGMENT = SHADER_HEAD + SHADER_LIGHT + `
flat in float share;
flat in vec4 ball;
flat in vec3 albedo;
uniform vec2 size;  // of the picture, pixels
out vec4 shown;
const float RIM = 0.9, LARGEST_RIM = 0.14, RIM_SHADE = 0.5;  // pixels, share of the radius
float rimShade(float rim, float width, float r) {
  return mix(RIM_SHADE, 1.0, clamp((rim - min(RIM * width, LARGEST_RIM * r)) / width + 0.5, 0.0, 1.0));
}
float depthOf(vec3 p) {
  return 0.5 * (range.y + range.x + 2.0 * range.y * range.x / p.z) / (range.y - range.x) + 0.5;
}

#ifdef PLANE
void main() {
  vec2 at = (2.0 * gl_FragCoord.xy / size - 1.0) * scale;
  float rim = ball.w - distance(at, ball.xy);
  if (rim < 0.0) discard;
  shown = vec4(display(albedo * rimShade(rim, pixel, ball.w)), 1.0);
  gl_FragDepth = 0.5;
}

#elif defined(ROUGH)
// A sphere as if seen without perspective.
void main() {
  vec2 q = share * (2.0 * gl_PointCoord - 1.0);
  float square = 1.0 - dot(q, q);
  if (square < 0.0) discard;
  vec3 n = vec3(q.x, -q.y, sqrt(square)), p = ball.xyz + ball.w * n;
  float light = 0.55 * max(dot(n, LAMP), 0.0) + 0.23 + 0.3 * n.z;
#ifdef CUT
  float above = dot(cut.xyz, p) + cut.w;
  if (above < 0.0) {
    // The face of the cut, where this line of sight meets it within the sphere.
    p.z -= above / cut.z;
    if (cut.z >= 0.0 || ball.z - p.z > ball.w * n.z) discard;
    light = 0.95;
  }
#endif
  shown = vec4(display(albedo * light), 1.0);
  gl_FragDepth = depthOf(p);
}

#else
void main() {
  vec3 color, c = ball.xyz;
  float r = ball.w;
  vec3 along = normalize(vec3((2.0 * gl_FragCoord.xy / size - 1.0) * scale, -1.0));
  float middle = dot(c, along);
  vec3 off = c - along * middle;
  float square = r * r - dot(off, off);
  if (square < 0.0) discard;
  float enter = middle - sqrt(square), leave = middle + sqrt(square);
  vec3 p = along * enter;
  color = lit(albedo, (p - c) / r, -along);
#ifdef CUT
  float beyond = dot(cut.xyz, p) + cut.w;
  if (beyond < 0.0) {
    // In front of the cut: seen is its face, if the ray meets that within the sphere.
    float slope = dot(cut.xyz, along), t = enter - beyond / slope;
    if (slope <= 0.0 || t > leave) discard;
    p = along * t;
    float height = dot(cut.xyz, c) + cut.w;
    float rim = sqrt(max(r * r - height * height, 0.0)) - distance(p, c - cut.xyz * height);
    color = albedo * 0.95 * rimShade(rim, pixel * -p.z, r);
  }
#endif
  gl_FragDepth = depthOf(p);
  shown = vec4(display(color), 1.0);
}
#endif
`;

const WALL_VERTEX = SHADER_HEAD + `
layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
uniform float lift;  // of few triangles, so that they do not cut into the spheres below
out vec3 at, facing;
void main() {
  at = toCamera(point + lift * normal - eye);
  facing = toCamera(normal);
  gl_Position = projected(at);
}
`;

// The wall is a veil, thicker where it is seen edge-on; a cut draws a line on it.
const WALL_FRAGMENT = SHADER_HEAD + SHADER_LIGHT + `
uniform vec3 bone, ink;
uniform float line;  // width of that of the cut, pixels
in vec3 at, facing;
out vec4 shown;
#ifdef PLANE
void main() { shown = vec4(ink, 1.0); }
#else
void main() {
  vec3 n = normalize(facing);
#ifdef ROUGH
  float edge = 1.0 - abs(n.z);
  vec3 color = bone * (0.75 + 0.25 * n.y);
#else
  float edge = 1.0 - abs(dot(n, normalize(at)));
  vec3 color = display(lit(bone * bone, faceforward(n, at, n), -normalize(at)));
#endif
  float opacity = 0.05 + 0.5 * edge * edge * edge;
#ifdef CUT
  float side = dot(cut.xyz, at) + cut.w;
  if (side < 0.0) discard;
  if (side < line * fwidth(side)) {
    color = ink;
    opacity = 0.9;
  }
#endif
  shown = vec4(color, opacity);
}
#endif
`;

const PRESENT_VERTEX = `
out vec2 place;
void main() {
  place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
  gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);
}
`;

// Shows the finished picture; darkens what lies between others that are nearer.
const PRESENT_FRAGMENT = `
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
  vec3 color = texture(colors, place).rgb;
  // Depths are read at the middles of their pixels: at edges between them rounding would decide.
  vec2 texel = 1.0 / vec2(textureSize(depths, 0)), here = (floor(place / texel) + 0.5) * texel;
  float own = distanceAt(here);
  if (!plane && own < 0.999 * range.y) {
    // Each pixel turns the spiral of samples: what is left of it looks like fine grain.
    float turn = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    // Things count as nearer if they rise above the plane through the pixel's surface.
    vec2 across = vec2(texel.x, 0.0), along = vec2(0.0, texel.y);
    vec2 ahead = vec2(distanceAt(here + across), distanceAt(here + along)) - own;
    vec2 behind = own - vec2(distanceAt(here - across), distanceAt(here - along));
    vec2 slope = mix(behind, ahead, lessThan(abs(ahead), abs(behind))) / texel;
    float shade = 0.0;
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
    }
    color *= 1.0 - 0.6 * smoothstep(0.05, 0.9, shade / float(SAMPLES));
    // What lies behind an edge is darker there, which sets off the parts of a bone from each other
    // (Luft, Colditz, Deussen 2006, doi:10.1145/1141911.1142016).
    float behindEdge = 0.0;
    for (int k = 0; k < SAMPLES / 2; ++k) {
      float share = (float(k) + 0.5) / float(SAMPLES / 2), angle = 2.3999632 * (float(k) + turn);
      vec2 off = vec2(cos(angle) * aspect, sin(angle)) * sqrt(share) * EDGE * reach / own;
      float rise = clamp(dot(slope, off), -2.0 * radius, 2.0 * radius);
      behindEdge += smoothstep(3.0, 12.0, (own + rise - distanceAt(here + off)) / radius);
    }
    color *= 1.0 - 0.55 * smoothstep(0.0, 0.8, behindEdge / float(SAMPLES / 2));
  }
  shown = vec4(color, 1.0);
}
`;

