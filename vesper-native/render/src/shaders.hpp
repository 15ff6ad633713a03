// SPDX-License-Identifier: Apache-2.0
// GLSL sources. Colours are linear; the framebuffer encodes sRGB. Positions are relative to the
// camera's target.
#pragma once

#include <string>

namespace vesper::render::shaders {

/// The vertical background gradient, for the background and for surfaces that fade into it.
inline const std::string kBackground = R"(
uniform vec3 background_top, background_bottom;
uniform float image_height;
vec3 background() {
  return mix(background_bottom, background_top, gl_FragCoord.y / image_height);
}
)";

inline const std::string kBackgroundVertex = R"(
void main() {  // one triangle that covers the picture
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}
)";

inline const std::string kBackgroundFragment = R"(
out vec4 pixel;
void main() { pixel = vec4(background(), 1.0); }
)";

/// Vertex attributes of all instanced meshes, and the function that transforms a vertex of an
/// instance.
inline const std::string kInstanceAttributes = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 row_x;
layout(location = 3) in vec4 row_y;
layout(location = 4) in vec4 row_z;
layout(location = 5) in vec3 colour;
layout(location = 6) in uint flags;
layout(location = 7) in vec2 coordinates;
layout(location = 8) in vec3 vertex_colour;
layout(location = 9) in uint instance_item;
layout(location = 10) in uint vertex_item;
vec3 placed() {
  vec4 p = vec4(position, 1.0);
  return vec3(dot(row_x, p), dot(row_y, p), dot(row_z, p));
}
)";

/// Preprocessor definitions select the variant: PLANE (grid, fading, no gloss), TEXTURED, SPHERE
/// (texture coordinates are longitude and latitude), and SHADOWS.
inline const std::string kSurfaceVertex = R"(
uniform mat4 clip;
uniform vec3 origin;  // the target in the world, for the grid
out vec3 at;
out vec3 facing;
out vec3 base;
flat out uint item;
#ifdef PLANE
out vec2 grid_at;
#endif
#ifdef SPHERE
out vec3 local;
#elif defined(TEXTURED)
out vec2 texture_at;
#endif
void main() {
  at = placed();
#ifdef SPHERE
  local = position;
#elif defined(TEXTURED)
  texture_at = coordinates;
#endif
  // Columns of the model are turned axes times sides; normals shrink with the square of a side.
  vec3 x = vec3(row_x.x, row_y.x, row_z.x);
  vec3 y = vec3(row_x.y, row_y.y, row_z.y);
  vec3 z = vec3(row_x.z, row_y.z, row_z.z);
  facing = normalize(x * (normal.x / dot(x, x)) + y * (normal.y / dot(y, y)) +
                     z * (normal.z / dot(z, z)));
#ifdef PLANE
  grid_at = vec2(dot(at + origin, normalize(x)), dot(at + origin, normalize(z)));
#endif
  base = colour * vertex_colour;
  item = flags;
  gl_Position = clip * vec4(at, 1.0);
}
)";

inline const std::string kSurfaceFragment = R"(
uniform vec4 eye;  // w = 0: a direction
uniform vec3 to_light;
uniform float light, ambient;
uniform vec3 material_colour;
uniform float gloss_exponent, gloss_strength, roughness, metallic;
in vec3 at;
in vec3 facing;
in vec3 base;
flat in uint item;
out vec4 pixel;

#ifdef TEXTURED
uniform sampler2D colour_map;
#ifdef SPHERE
in vec3 local;
float smaller(float a, float b) { return abs(a) < abs(b) ? a : b; }
vec3 texture_colour() {
  vec3 d = normalize(local);
  vec2 p = vec2(atan(d.x, d.z) / 6.28318531 + 0.5, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);
  float u = fract(p.x + 0.5);  // jumps elsewhere: one of the two has the true slopes
  vec2 dx = vec2(smaller(dFdx(p.x), dFdx(u)), dFdx(p.y));
  vec2 dy = vec2(smaller(dFdy(p.x), dFdy(u)), dFdy(p.y));
  return textureGrad(colour_map, p, dx, dy).rgb;
}
#else
in vec2 texture_at;
vec3 texture_colour() { return texture(colour_map, texture_at).rgb; }
#endif
vec3 surface_colour() { return base * material_colour * texture_colour(); }
#else
vec3 surface_colour() { return base * material_colour; }
#endif

#ifdef SHADOWS
uniform sampler2DShadow shadow_map;
uniform mat4 shadow_matrix;
uniform float shadow_blur;    // between samples [texture coordinates]
uniform float shadow_offset;  // [m], away from the surface, against self-shadowing
float sunlit(vec3 n) {
  vec3 s = (shadow_matrix * vec4(at + n * shadow_offset, 1.0)).xyz;
  float sum = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      sum += texture(shadow_map, vec3(s.xy + (vec2(i, j) - 1.5) * shadow_blur, s.z));
  return sum / 16.0;
}
#else
float sunlit(vec3 n) { return 1.0; }
#endif

#ifdef PLANE
uniform float grid_spacing;  // [m], a power of ten
uniform float fade_radius;   // [m]
in vec2 grid_at;
float lines(vec2 pixel_size, float spacing, float width) {
  vec2 pixels = pixel_size / spacing;
  vec2 off = abs(fract(grid_at / spacing - 0.5) - 0.5) / pixels;
  vec2 cover = clamp(0.5 + 0.5 * width - off, 0.0, 1.0) * (1.0 - smoothstep(0.04, 0.2, pixels));
  return max(cover.x, cover.y);
}
vec3 with_grid(vec3 colour) {
  vec2 pixel_size = vec2(length(vec2(dFdx(grid_at.x), dFdy(grid_at.x))),
                         length(vec2(dFdx(grid_at.y), dFdy(grid_at.y))));
  float line = max(0.16 * lines(pixel_size, grid_spacing, 1.0),
                   0.34 * lines(pixel_size, 10.0 * grid_spacing, 1.4));
  float dark = step(dot(colour, vec3(0.2126, 0.7152, 0.0722)), 0.1);
  return mix(colour, vec3(dark), line * (item & 2u) * 0.5);
}
#endif

void main() {
  vec3 n = normalize(facing);
  vec3 to_eye = normalize(eye.xyz - at * eye.w);
  if (dot(n, to_eye) < 0.0) n = -n;
  vec3 colour = surface_colour();
#ifdef PLANE
  colour = with_grid(colour);
#endif
  float open = sunlit(n) * light;
  float sun = max(dot(n, to_light), 0.0) * open;
  vec3 sky = mix(vec3(0.5, 0.49, 0.48), vec3(1.0), 0.5 + 0.5 * n.y) * ambient;
#ifdef PLANE
  vec3 lit = colour * (sky + sun);
#else
  vec3 diffuse = colour * (1.0 - metallic);
  vec3 lit = diffuse * (sky + sun);
  lit += 0.18 * ambient * diffuse * dot(n, to_light);  // sides in shadow differ, too
  float gloss = pow(max(dot(n, normalize(to_light + to_eye)), 0.0), gloss_exponent);
  lit += gloss_strength * gloss * open * smoothstep(0.0, 0.15, dot(n, to_light)) *
         mix(vec3(1.0), colour, metallic);
  // What a metal mirrors: a bright sky over a dark ground, blurred as it is rough.
  float blur = 0.1 + roughness;
  float above = smoothstep(-blur, blur, reflect(-to_eye, n).y);
  lit += metallic * colour * mix(0.45, 1.3, above) * (ambient + 0.5 * light);
#endif
  vec3 shown = mix(lit, colour, float(item & 1u));
#ifdef PLANE
  float distance = length(at) / fade_radius;
  shown = mix(shown, background(), smoothstep(1.0, 4.0, distance) * float(item >> 2u));
#endif
  pixel = vec4(shown, 1.0);
}
)";

inline const std::string kShadowVertex = R"(
uniform mat4 shadow_matrix;
void main() {
  vec3 s = (shadow_matrix * vec4(placed(), 1.0)).xyz * 2.0 - 1.0;
  gl_Position = vec4(s, (flags & 1u) == 0u ? 1.0 : -1.0);  // unlit: behind the light
}
)";

inline const std::string kShadowFragment = "void main() {}\n";

/// Shaders that write the item and the depth at the centre of each pixel.
inline const std::string kSenseVertex = R"(
uniform mat4 clip;
flat out uint item;
void main() {
  item = instance_item | vertex_item;
  gl_Position = clip * vec4(placed(), 1.0);
}
)";

inline const std::string kSenseLineVertex = R"(
layout(location = 0) in vec4 clip;
layout(location = 2) in uint line_item;
flat out uint item;
void main() {
  item = line_item;
  gl_Position = clip;
}
)";

inline const std::string kSenseFragment = R"(
flat in uint item;
layout(location = 0) out uint seen;
layout(location = 1) out float depth;
void main() {
  seen = item;
  depth = 1.0 / gl_FragCoord.w;  // a perspective view's w is the depth
}
)";

inline const std::string kLineVertex = R"(
layout(location = 0) in vec4 clip;
layout(location = 1) in vec4 srgb;
flat out vec3 colour;
void main() {
  colour = mix(pow((srgb.rgb + 0.055) / 1.055, vec3(2.4)), srgb.rgb / 12.92,
               lessThanEqual(srgb.rgb, vec3(0.04045)));
  gl_Position = clip;
}
)";

inline const std::string kLineFragment = R"(
flat in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(colour, 1.0); }
)";

}  // namespace vesper::render::shaders
