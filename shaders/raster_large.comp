#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Cells that are large on the screen, reach before the near plane or have gaps -> packed pixels, a workgroup
// each.

#include "shaders/raster_common.h"

layout(local_size_x = RASTER_LARGE_LANES) in;

struct Point {
    int64_t x, y;  // subpixels
    float z;
    float share;  // 1 / w
    vec3 colour;  // times share
};

Point to_screen(vec4 clip, vec3 colour) {
    return Point(int64_t(view_subpixels(clip.x / clip.w, float(push.picture_width))),
                 int64_t(view_subpixels(clip.y / clip.w, float(push.picture_height))), clip.z / clip.w, 1.0f / clip.w,
                 colour * (1.0f / clip.w));
}

int64_t edge(Point a, Point b, int64_t x, int64_t y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

int64_t least_inside(Point a, Point b) {
    return b.y < a.y || (b.y == a.y && b.x > a.x) ? 0l : 1l;
}

// Pixels whose centres lie within [least, greatest] subpixels, on a side of `size`.
ivec2 pixels_between(int64_t least, int64_t greatest, uint size) {
    const int64_t half_pixel = VIEW_SUBPIXELS / 2;
    return ivec2(clamp((least + (half_pixel - 1l)) >> 8, 0l, int64_t(size)),
                 clamp((greatest - half_pixel) >> 8, -1l, int64_t(size) - 1l));
}

// Limits a line's pixels, counted from one where the edge from a to b has the value `at`, to those inside it.
void limit_span(Point a, Point b, int64_t at, inout int64_t first, inout int64_t last) {
    const int64_t step_right = (a.y - b.y) * VIEW_SUBPIXELS, lacks = least_inside(a, b) - at;
    if (step_right > 0l && lacks > 0l) first = max(first, (lacks + step_right - 1l) / step_right);
    if (step_right < 0l) last = min(last, lacks > 0l ? -1l : lacks / step_right);
    if (step_right == 0l && lacks > 0l) last = -1l;
}

void fill_triangle(Point a, Point b, Point c, float scale_of_z) {
    int64_t area = edge(a, b, c.x, c.y);
    if (area == 0l) return;
    if (area < 0l) {
        const Point other = b;
        b = c;
        c = other;
        area = -area;
    }
    const ivec2 columns = pixels_between(min(a.x, min(b.x, c.x)), max(a.x, max(b.x, c.x)), push.picture_width);
    const ivec2 lines = pixels_between(min(a.y, min(b.y, c.y)), max(a.y, max(b.y, c.y)), push.picture_height);
    const float scale = 1.0f / float(area);
    for (int y = lines.x; y <= lines.y; ++y) {
        const int64_t px = int64_t(columns.x) * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
        const int64_t py = int64_t(y) * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
        const int64_t at_ab = edge(a, b, px, py), at_ca = edge(c, a, px, py);
        int64_t first = 0l, last = int64_t(columns.y - columns.x);
        limit_span(a, b, at_ab, first, last);
        limit_span(b, c, edge(b, c, px, py), first, last);
        limit_span(c, a, at_ca, first, last);
        for (int64_t x = first + int64_t(gl_LocalInvocationID.x); x <= last; x += RASTER_LARGE_LANES) {
            const int64_t ab = at_ab + (a.y - b.y) * VIEW_SUBPIXELS * x, ca = at_ca + (c.y - a.y) * VIEW_SUBPIXELS * x;
            const float of_b = float(ca) * scale, of_c = float(ab) * scale;
            const float share = a.share + of_b * (b.share - a.share) + of_c * (c.share - a.share);
            plot(columns.x + int(x), y, (a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z)) * scale_of_z,
                 (a.colour + of_b * (b.colour - a.colour) + of_c * (c.colour - a.colour)) / share);
        }
    }
}

struct Vertex {
    vec4 clip;
    vec3 colour;
    float q;
};

Vertex vertex(uint cell) {
    const float q = q_at(cell);
    const Projected seen = projected(cell, cell % push.pitch, cell / push.pitch);
    return Vertex(seen.clip, seen.colour, q);
}

void draw_triangle(Vertex a, Vertex b, Vertex c, float scale_of_z) {
    const Vertex corners[3] = Vertex[3](a, b, c);
    Point points[4];
    int count = 0;
    for (int k = 0; k < 3; ++k) {
        const Vertex from = corners[k], to = corners[k == 2 ? 0 : k + 1];
        const float inside_from = from.clip.w - from.clip.z, inside_to = to.clip.w - to.clip.z;
        if (inside_from >= 0.0f) points[count++] = to_screen(from.clip, from.colour);
        if ((inside_from >= 0.0f) == (inside_to >= 0.0f)) continue;
        const float share = inside_from / (inside_from - inside_to);
        vec4 clip = from.clip + share * (to.clip - from.clip);
        clip.z = clip.w;
        points[count++] = to_screen(clip, from.colour + share * (to.colour - from.colour));
    }
    if (count >= 3) fill_triangle(points[0], points[1], points[2], scale_of_z);
    if (count == 4) fill_triangle(points[0], points[2], points[3], scale_of_z);
}

void draw_or_fill(Vertex a, Vertex b, Vertex c, bool are_gaps_alone, vec3 fill) {
    const bool cut = is_cut(a.q, b.q, c.q);
    if (!cut && !are_gaps_alone) draw_triangle(a, b, c, 1.0f);
    if (!cut || push.fills_gaps == 0u || a.q == 0.0f || b.q == 0.0f || c.q == 0.0f) return;
    a.colour = b.colour = c.colour = fill;
    draw_triangle(a, b, c, GAP_Z);
}

void main() {
    for (uint n = gl_WorkGroupID.x; n < min(large_count, push.width * push.height); n += gl_NumWorkGroups.x) {
        const bool are_gaps_alone = (large_cells[n] & RASTER_GAPS_ALONE) != 0u;
        const uint cell = large_cells[n] & ~RASTER_GAPS_ALONE;
        const Vertex top_left = vertex(cell), bottom_right = vertex(cell + push.pitch + 1u);
        vec3 fill = vec3(0.0f);
        if (push.fills_gaps != 0u && (is_cut(top_left.q, q_at(cell + 1u), bottom_right.q) ||
                                      is_cut(top_left.q, bottom_right.q, q_at(cell + push.pitch))))
            fill = gap_fill(ivec2(cell % push.pitch, cell / push.pitch), ivec2(push.width, push.height));
        draw_or_fill(top_left, vertex(cell + 1u), bottom_right, are_gaps_alone, fill);
        draw_or_fill(top_left, bottom_right, vertex(cell + push.pitch), are_gaps_alone, fill);
    }
}
