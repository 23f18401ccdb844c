// Particles as spheres: each is a square that faces the eye, of which the sphere's disc is kept, at the sphere's depth.
// In a plane the discs overlap, and where they do the nearest centre wins, so that a body looks filled.

const VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 start;
layout(location = 2) in float value;
uniform mat4 view, projection;
uniform vec3 low, size;
uniform float radius, stretch, behind;
uniform vec2 scaling;
uniform vec4 cut;
out vec2 corner;
out vec3 center;
flat out float level;
void main() {
  vec3 from = low + size * start / 65534.0;
  vec3 x = from + stretch * (low + size * place / 65534.0 - from);
  corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  center = (view * vec4(x, 1.0)).xyz;
  level = clamp(value * scaling.x + scaling.y, 0.0, 1.0);
  gl_Position = projection * vec4(center + radius * vec3(corner, 0.0) - vec3(0.0, 0.0, behind), 1.0);
  // not there, or cut away
  if (place.x > 65534.5 || dot(cut.xyz, x) > cut.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec2 corner;
in vec3 center;
flat in float level;
uniform mat4 projection;
uniform float radius, shading, rim, behind, opacity;
uniform bool mapped;
uniform vec3 color;
uniform sampler2D map;
out vec4 shown;
void main() {
  float away = dot(corner, corner), edge = fwidth(away);
  float inside = clamp((1.0 - away) / max(edge, 1e-6) + 0.5, 0.0, 1.0);
  if (inside <= 0.0) discard;
  vec3 normal = vec3(corner, sqrt(max(1.0 - away, 0.0)));
  vec4 clip = projection * vec4(center + radius * normal - vec3(0.0, 0.0, behind), 1.0);
  gl_FragDepth = clamp(0.5 * clip.z / clip.w + 0.5, 0.0, 1.0);
  vec3 base = mapped ? texture(map, vec2((level * 255.0 + 0.5) / 256.0, 0.5)).rgb : color;
  float light = 0.55 + 0.45 * max(dot(normal, normalize(vec3(-0.35, 0.55, 0.76))), 0.0);
  float shine = 0.16 * pow(max(dot(normal, normalize(vec3(-0.2, 0.35, 0.92))), 0.0), 24.0);
  vec3 lit = mix(base, base * light + shine, shading) * (1.0 - rim * away * away);
  shown = vec4(lit, opacity < 1.0 ? opacity : inside);
}`;

/** Compile the program; an error says what the driver says. */
function compile(gl) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const places = {};
  for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
    const { name } = gl.getActiveUniform(program, k);
    places[name] = gl.getUniformLocation(program, name);
  }
  return { program, places };
}
