// SPDX-License-Identifier: Apache-2.0
// Draws a clip's surface with WebGL2, and the fingers above it on a 2D canvas.
//
// `SurfacePicture` keeps the newest planes and draws them; `paint_fingers` draws fingers as the window does
// (player/window/finger_halos.cpp).
//
//     const picture = new SurfacePicture(canvas);     // throws a sentence for people
//     picture.show(planes);                           // of a 'state' of the worker
//     picture.draw(state.matrix, state.own_view, 'depth');
//
// All rows of cells are one triangle strip without vertex data: the shader fetches depths by gl_VertexID. Triangles
// and their diagonals are those of the solver (face_under in haptics_cpu/height_field.hpp). In the clip's own view
// colours lie where they are in the picture, whatever the depth: then two triangles are enough, which a CPU draws in
// a tenth of the time.

const overlays = ['colour', 'shape', 'depth', 'stiffness', 'friction', 'height', 'missing'];
const missing = [87, 181, 232], bytes_of = (colour) => [0, 8, 16].map((shift) => colour >> shift & 255);
export const missing_colour = `rgb(${missing})`;
export const css_of = (colour) => `rgb(${bytes_of(colour)})`;

const both_begin = `#version 300 es
${overlays.map((name, k) => `#define SHOWS_${name} (shown == ${k})`).join('\n')}
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D depths;
uniform ivec2 size;
uniform int shown;
uniform bool is_flat;
`;
const vertex_source = `${both_begin}
uniform mat4 clip_from_lattice;
uniform int stride, last;
uniform float cut_ratio, hole_q;
out vec2 at;
out float depth, light;
flat out float cut;  // of the triangle whose last vertex this is

// A row's first and last vertices come twice: between rows the strip has no area.
ivec2 place(int k) {
  int row = gl_VertexID / (last + 3);
  k = clamp(k - row * (last + 3) - 1, 0, last);
  return min(ivec2(k >> 1, row + 1 - (k & 1)) * stride, size - 1);
}
float q_at(ivec2 pixel) {
  float planar = texelFetch(depths, pixel, 0).r;
  return planar > 0.0 ? 1.0 / planar : hole_q;
}
// Slope of the surface along an axis of the picture, as of a camera with a focal length of its width; 0 beside a hole.
float slope(ivec2 pixel, ivec2 step, float q) {
  float after = q_at(min(pixel + step, size - 1)), before = q_at(max(pixel - step, ivec2(0)));
  return after > 0.0 && before > 0.0 ? float(size.x) * (before - after) / (float(2 * stride) * q) : 0.0;
}
void main() {
  ivec2 pixel = place(gl_VertexID);
  float q = q_at(pixel);
  float b = q_at(place(gl_VertexID - 1)), c = q_at(place(gl_VertexID - 2));
  float least = min(q, min(b, c)), greatest = max(q, max(b, c));
  cut = least <= 0.0 || cut_ratio * greatest > least ? 1.0 : 0.0;
  // A corner without depth takes that of a neighbour: its cut triangles then stay small, and cost little.
  if (q <= 0.0)
    for (int k = -2; k <= 2; ++k) q = max(q, q_at(place(gl_VertexID + k)));
  light = 1.0;
  if (!SHOWS_colour) {  // colours have their own light
    vec3 normal = vec3(slope(pixel, ivec2(stride, 0), q), slope(pixel, ivec2(0, stride), q), 1.0);
    light = 0.34 + 0.72 * max(dot(normalize(normal), normalize(vec3(-0.45, -0.6, 0.8))), 0.0);
  }
  at = vec2(pixel);
  depth = q > 0.0 ? 1.0 / q : 0.0;
  if (is_flat) q = 1.0, cut = 0.0;
  vec4 p = clip_from_lattice * vec4(at, 1.0, q);
  gl_Position = q > 0.0 ? vec4(p.x, -p.y, p.w - 2.0 * p.z, p.w) : vec4(2.0, 2.0, 2.0, 1.0);
}`;

const fragment_source = `${both_begin}
uniform sampler2D colour, haptic, heights, ramp;
uniform vec2 range;
in vec2 at;
in float depth, light;
flat in float cut;
out vec4 painted;

void main() {
  if (cut > 0.5) discard;
  ivec2 pixel = clamp(ivec2(at + 0.5), ivec2(0), size - 1);
  if (is_flat && texelFetch(depths, pixel, 0).r <= 0.0) discard;
  float share = clamp((depth - range.x) / max(range.y - range.x, 1e-9), 0.0, 1.0);
  vec3 seen;
  if (SHOWS_colour) seen = texture(colour, (at + 0.5) / vec2(size)).rgb;
  else if (SHOWS_shape) seen = mix(vec3(0.93, 0.89, 0.83), vec3(0.36, 0.39, 0.45), share) * light;
  else if (SHOWS_missing) {
    bool striped = ((pixel.x + pixel.y) >> 2 & 1) == 1;
    bool valid = texelFetch(depths, pixel, 0).r > 0.0;
    seen = valid ? vec3(ivec3(${missing})) / 255.0 * (0.5 + 0.5 * light) : vec3(striped ? 0.36 : 0.24);
  } else {
    if (SHOWS_depth) share = 1.0 - share;
    else if (SHOWS_stiffness) share = texelFetch(haptic, pixel, 0).r;
    else if (SHOWS_friction) share = texelFetch(haptic, pixel, 0).g;
    else share = clamp(texelFetch(heights, pixel, 0).r / max(range.y, 1e-9), 0.0, 1.0);
    float end = 0.5 / float(textureSize(ramp, 0).x);
    seen = texture(ramp, vec2(mix(end, 1.0 - end, share), 0.5)).rgb * (SHOWS_depth ? 1.0 : 0.55 + 0.45 * light);
  }
  painted = vec4(seen, 1.0);
}`;

// By sampler: internal format, format, type of a sample, and the filter.
const textures = {depths: ['R32F', 'RED', 'FLOAT', 'NEAREST'], colour: ['RGBA8', 'RGBA', 'UNSIGNED_BYTE', 'LINEAR'],
  haptic: ['RGB8', 'RGB', 'UNSIGNED_BYTE', 'NEAREST'], heights: ['R32F', 'RED', 'FLOAT', 'NEAREST'],
  ramp: ['RGB8', 'RGB', 'UNSIGNED_BYTE', 'LINEAR']};
export class SurfacePicture {
  constructor(canvas) {
    Object.assign(this, {canvas, planes: {}, stride: 1, pictures: 0, drawn_ms: 0, highest: 0, range: [0, 1]});
    this.gl = canvas.getContext('webgl2', {alpha: false, antialias: false});
    if (!this.gl) throw new Error('This page needs WebGL2, which this browser does not offer.');
    this.prepare();
  }

  // Also after a lost context.
  prepare() {
    const gl = this.gl, program = gl.createProgram();
    for (const [source, kind] of [[vertex_source, gl.VERTEX_SHADER], [fragment_source, gl.FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error('This browser cannot compile the shaders of the page: ' + gl.getProgramInfoLog(program));
    gl.useProgram(program);
    this.uniforms = new Proxy({}, {get: (kept, name) => (kept[name] ??= gl.getUniformLocation(program, name))});
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.055, 0.06, 0.072, 1);
    for (const [unit, [name, [, , , filter]]] of Object.entries(textures).entries()) {
      gl.uniform1i(this.uniforms[name], unit);
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
      for (const [which, value] of [['MIN_FILTER', filter], ['MAG_FILTER', filter], ['WRAP_S', 'CLAMP_TO_EDGE'],
        ['WRAP_T', 'CLAMP_TO_EDGE']])
        gl.texParameteri(gl.TEXTURE_2D, gl['TEXTURE_' + which], gl[value]);
      this.fill(name, 1, 1, null);
    }
    this.stale = new Set(Object.keys(this.planes));
  }

  fill(name, width, height, samples) {
    const gl = this.gl, [internal, format, type] = textures[name].map((constant) => gl[constant]);
    gl.activeTexture(gl.TEXTURE0 + Object.keys(textures).indexOf(name));
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, samples);
  }

  // Forgets the planes of the clip before.
  begin({width, height, far, table}) {
    const most = this.gl.getParameter(this.gl.MAX_TEXTURE_SIZE) ?? Infinity;
    if (Math.max(width, height) > most)
      throw new Error(`This picture has ${width} x ${height} pixels; this device draws ${most} a side.`);
    this.planes.colour?.close();
    const ramp = new Uint8Array(table.ramp.flatMap(bytes_of));
    this.planes = {ramp: Object.assign(ramp, {width: table.ramp.length, height: 1})};
    this.stale = new Set(['ramp']);
    Object.assign(this, {width, height, table, range: [0, 1], is_measured: false, far: 0.999 * (far || Infinity)});
  }

  // A plane that is not there stays as it was. All are kept for a lost context.
  show(planes) {
    if (planes.colour) this.planes.colour?.close();
    for (const name of ['depths', 'colour', 'haptic', 'heights'].filter((name) => planes[name])) {
      this.planes[name] = planes[name];
      this.stale.add(name);
    }
  }

  // Brings the planes that are shown up to date: the others would cost a slow device a third of its pictures.
  update(shown) {
    const others = {colour: 'colour', stiffness: 'haptic', friction: 'haptic', height: 'heights'};
    if (shown !== 'colour' && this.stale.has('depths')) this.measure(this.planes.depths);
    for (const name of ['ramp', 'depths', others[shown]]) {
      const plane = this.planes[name];
      if (!plane || !this.stale.delete(name)) continue;
      const samples = name === 'heights' ? Float32Array.from(plane) : plane;
      if (name === 'heights') this.highest = samples.reduce((most, value) => Math.max(most, value), 0);
      this.fill(name, plane.width ?? this.width, plane.height ?? this.height, samples);  // an image has its own
    }
  }

  // The depths that colours spread over: those of all but 1 % of the pixels at either end, without the far plane;
  // eased, so that colours do not flicker.
  measure(depths) {
    const step = Math.ceil(depths.length / 4000);
    const found = new Float32Array(4000).map((_, k) => depths[k * step] ?? 0)
      .filter((depth) => depth > 0 && depth < this.far).sort();
    const ends = found.length ? [0.01, 0.99].map((share) => found[Math.floor(share * (found.length - 1))]) : [1, 2];
    this.range = ends.map((end, k) => (this.is_measured ? this.range[k] + 0.1 * (end - this.range[k]) : end));
    this.is_measured = true;
  }

  draw(matrix, own_view, overlay) {
    const {gl, width, height, planes: {depths, colour}, uniforms: at} = this;
    if (!depths || gl.isContextLost()) return false;
    const began = ++this.pictures % 8 ? 0 : performance.now();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const shown = overlay === 'colour' && !colour ? 'shape' : overlay;
    this.update(shown);
    const is_flat = own_view && shown === 'colour';
    const stride = is_flat ? Math.max(width, height) : this.stride * Math.ceil(Math.sqrt(width * height / 1.2e6));
    const columns = Math.ceil((width - 1) / stride) + 1, rows = Math.ceil((height - 1) / stride);
    gl.uniformMatrix4fv(at.clip_from_lattice, false, matrix);
    gl.uniform2i(at.size, width, height);
    gl.uniform1i(at.is_flat, is_flat);
    gl.uniform1i(at.stride, stride);
    gl.uniform1i(at.last, 2 * columns - 1);
    gl.uniform1i(at.shown, overlays.indexOf(shown));
    gl.uniform1f(at.hole_q, shown === 'missing' ? 1 / this.range[1] : 0);
    // Turned views do not draw a curtain between depths that differ by more (shaders/cut_rule.h).
    gl.uniform1f(at.cut_ratio, own_view ? 0 : 1 / (this.table.cut_ratio ** stride));
    gl.uniform2f(at.range, ...(shown === 'height' ? [0, this.highest] : this.range));
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, (2 * columns + 2) * rows);
    // Now and then wait for a picture, by reading a pixel, to know how long one takes.
    if (began) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    this.drawn_ms = began ? performance.now() - began : 0;
    return true;
  }
}

// Fingers above the picture; `unit`: canvas pixels of a CSS pixel, `size`: of the picture, `least`: a finger's radius,
// CSS pixels. The canvas is as small as it can be: one as large as the picture would halve a slow device's rate.
export function paint_fingers(canvas, unit, size, least, fingers, {fingers: colours, hover_mm, noticed_degrees}) {
  const c = canvas.getContext('2d'), turn = 2 * Math.PI, radius = Math.max(least * unit, 0.016 * size);
  const points = fingers.flatMap(({at, goal, tip}) => [at, goal, tip])
    .map((place) => place.map((value) => Math.min(Math.max(value, -radius), 2 * size)));
  canvas.hidden = !points.length;
  if (canvas.hidden) return;
  const [left, top] = [0, 1].map((k) => Math.floor(Math.min(...points.map((p) => p[k])) - 5 * radius));
  const [right, bottom] = [0, 1].map((k) => Math.max(...points.map((p) => p[k])) + 5 * radius);
  const sides = [right - left, bottom - top].map((side) => 64 * Math.ceil(side / 64));
  if (canvas.width !== sides[0] || canvas.height !== sides[1]) [canvas.width, canvas.height] = sides;
  Object.assign(canvas.style, {left: `${left / unit}px`, top: `${top / unit}px`, width: `${sides[0] / unit}px`,
    height: `${sides[1] / unit}px`});
  c.setTransform(1, 0, 0, 1, -left, -top);
  c.clearRect(left, top, ...sides);
  const stroke = (style, width) => Object.assign(c, {lineWidth: width * unit, strokeStyle: style}).stroke();
  const circle = (x, y, r, style, width = 0, share = 1) => {  // filled; with a width: a ring, clockwise from above
    c.beginPath();
    c.arc(x, y, r, -turn / 4, turn * (share - 0.25));
    if (width) stroke(style, width);
    else Object.assign(c, {fillStyle: style}).fill();
  };
  const path = (...places) => {
    c.beginPath();
    for (const place of places) c.lineTo(...place);
  };
  const line = (from, to, style, width) => {
    path(from, to);
    stroke(style, width);
  };
  const shade = (x, y, r, ...stops) => {
    const gradient = c.createRadialGradient(x, y, 0, x, y, r);
    stops.forEach((stop, k) => gradient.addColorStop(k / (stops.length - 1), stop));
    circle(x, y, r, gradient);
  };
  fingers.forEach((finger, k) => {
    const {at, goal, tip, touching, newtons, depth_mm} = finger, [x, y] = at;
    const lift = touching ? 0 : Math.min(Math.max(0, -depth_mm) / hover_mm, 2);
    const dark = [0.75, 0.4, 0].map((share) => `rgba(0,0,0,${share / (1 + lift)})`);
    shade(x + lift * radius, y + (0.3 + lift) * radius, (1.6 + 0.5 * lift) * radius, ...dark);
    if (touching) {
      line(at, goal, '#fff6', 1.5);
      circle(...goal, 0.7 * radius, '#fff4');
    }
    circle(x, y, radius + 1.5 * unit, '#ffffffe6');
    circle(x, y, radius, css_of(colours[k]));
    shade(x - 0.35 * radius, y - 0.4 * radius, 0.9 * radius, '#ffffffbf', '#fff0');
    // The ring shrinks as the finger comes down and presses; it is full at the limit.
    const r = radius * (1.75 + Math.min(0.8, 0.4 * lift) - Math.min(0.3, 0.06 * newtons));
    circle(x, y, r, '#0a0c108c', 4.5);
    circle(x, y, r, '#fff6', 1.5);
    // White, to amber where the hand may notice how wrong the direction may be.
    const error = Math.min((finger.error_degrees || 0) / noticed_degrees, 1);
    circle(x, y, r, `rgb(255 ${255 - 95 * error} ${255 - 255 * error})`, 4, Math.min(finger.share, 1));
    if (!touching) return;
    const dx = tip[0] - x, dy = tip[1] - y, long = Math.hypot(dx, dy);
    if (long < 0.8 * radius) return circle(x, y, 0.32 * radius, '#fffffff2');  // seen end on
    const head = Math.min(14 * unit, 0.6 * long) / long, side = 0.5 * head;
    const neck = [tip[0] - dx * head, tip[1] - dy * head];
    line(at, neck, '#0a0c1099', 6);
    line(at, neck, '#bfe0f7', 3.5);
    path(tip, [neck[0] - side * dy, neck[1] + side * dx], [neck[0] + side * dy, neck[1] - side * dx]);
    Object.assign(c, {fillStyle: '#bfe0f7'}).fill();
  });
}
