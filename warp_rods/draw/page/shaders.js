// Rods are chains of capsules: each is a box whose fragments find where their ray meets the capsule. Tubes are round at
// any distance, and no mesh is stored.

const LIGHTING = `
  vec3 lit(vec3 colour, vec3 normal, vec3 view, vec3 key) {
    float diffuse = 0.42 + 0.58 * max(dot(normal, key), 0.0);
    float gloss = 0.25 * pow(max(dot(normal, normalize(key + view)), 0.0), 40.0);
    float rim = mix(0.62, 1.0, smoothstep(0.0, 0.55, max(dot(normal, view), 0.0)));
    return colour * diffuse * rim + gloss;
  }`;

const ROD_VERTEX = `#version 300 es
  precision highp float; precision highp int; precision highp usampler2D;
  uniform usampler2D points, values;
  uniform int nodes, width;
  uniform vec3 low, spacing;
  uniform float radius;
  uniform mat4 matrix;
  in vec3 corner;
  flat out vec3 first, last;
  flat out vec2 shade;
  out vec3 place;
  ivec2 texel(int k) { return ivec2(k % width, k / width); }
  vec3 point(int k) { return low + spacing * vec3(texelFetch(points, texel(k), 0).rgb); }
  float value(int k) { return float(texelFetch(values, texel(k), 0).r); }
  void main() {
    int segments = nodes - 1;
    int k = (gl_InstanceID / segments) * nodes + gl_InstanceID % segments;
    first = point(k);
    last = point(k + 1);
    shade = vec2(value(k), value(k + 1));
    vec3 along = last - first;
    along = dot(along, along) > 0.0 ? normalize(along) : vec3(1.0, 0.0, 0.0);
    vec3 across = normalize(cross(along, abs(along.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec3 third = cross(along, across);
    place = mix(first, last, corner.z)
          + radius * (corner.x * across + corner.y * third + (2.0 * corner.z - 1.0) * along);
    gl_Position = matrix * vec4(place, 1.0);
  }`;

const ROD_FRAGMENT = `#version 300 es
  precision highp float; precision highp int;
  uniform float radius;
  uniform mat4 matrix;
  uniform vec3 eye, key, lacking;
  uniform sampler2D colours;
  flat in vec3 first, last;
  flat in vec2 shade;
  in vec3 place;
  out vec4 colour;
  ${LIGHTING}
  const float MISS = 1e30;
  // Where a line from "from" along the unit vector "ray" enters the capsule. "from" is near the capsule, as squares of
  // large distances would lose the radius to rounding.
  float entry(vec3 from, vec3 ray, vec3 axis) {
    vec3 start = from - first;
    float length2 = dot(axis, axis), alongRay = dot(axis, ray), alongStart = dot(axis, start);
    float a = length2 - alongRay * alongRay;
    float b = length2 * dot(start, ray) - alongStart * alongRay;
    float c = length2 * (dot(start, start) - radius * radius) - alongStart * alongStart;
    float h = b * b - a * c;
    if (h < 0.0) return MISS;
    float t = a > 0.0 ? (-b - sqrt(h)) / a : 0.0;
    float height = alongStart + t * alongRay;
    if (a > 0.0 && height > 0.0 && height < length2) return t;
    vec3 end = height <= 0.0 ? start : from - last;
    b = dot(ray, end);
    h = b * b - dot(end, end) + radius * radius;
    return h > 0.0 ? -b - sqrt(h) : MISS;
  }
  void main() {
    vec3 ray = normalize(place - eye), axis = last - first, middle = 0.5 * (first + last);
    vec3 from = place + ray * dot(middle - place, ray);
    float t = entry(from, ray, axis);
    if (t == MISS) discard;
    vec3 hit = from + t * ray;
    float share = clamp(dot(hit - first, axis) / max(dot(axis, axis), 1e-30), 0.0, 1.0);
    vec3 normal = normalize(hit - first - share * axis);
    vec3 base = max(shade.x, shade.y) > 254.5 ? lacking
              : texture(colours, vec2((mix(shade.x, shade.y, share) + 0.5) / 255.0, 0.5)).rgb;
    colour = vec4(lit(base, normal, -ray, key), 1.0);
    vec4 clip = matrix * vec4(hit, 1.0);
    gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  }`;

const SHEET_VERTEX = `#version 300 es
  precision highp float;
  uniform mat4 matrix;
  in vec3 point, normal, tint;
  out vec3 place, outward, base;
  void main() { place = point; outward = normal; base = tint; gl_Position = matrix * vec4(point, 1.0); }`;

// A membrane is clear where it is seen face on, and denser towards its outline.
const SHEET_FRAGMENT = `#version 300 es
  precision highp float;
  uniform vec3 eye, key;
  uniform float opacity;
  in vec3 place, outward, base;
  out vec4 colour;
  void main() {
    vec3 view = normalize(eye - place), normal = normalize(outward);
    normal = dot(normal, view) < 0.0 ? -normal : normal;
    float edge = pow(1.0 - dot(normal, view), 2.5);
    float alpha = opacity + (0.75 - opacity) * edge;
    colour = vec4(base * (0.72 + 0.28 * max(dot(normal, key), 0.0)) * (1.0 - 0.35 * edge), alpha);
  }`;

const LINE_FRAGMENT = `#version 300 es
  precision highp float;
  out vec4 colour;
  void main() { colour = vec4(0.55, 0.55, 0.58, 1.0); }`;
