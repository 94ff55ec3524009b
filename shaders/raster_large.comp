#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Cells that are large on the screen or reach before the near plane -> packed pixels, a workgroup each.

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

void fill_triangle(Point a, Point b, Point c) {
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
    for (int y = lines.x; y <= lines.y; ++y)
        for (int x = columns.x + int(gl_LocalInvocationID.x); x <= columns.y; x += RASTER_LARGE_LANES) {
            const int64_t px = int64_t(x) * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
            const int64_t py = int64_t(y) * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
            const int64_t ab = edge(a, b, px, py), bc = edge(b, c, px, py), ca = edge(c, a, px, py);
            if (ab < least_inside(a, b) || bc < least_inside(b, c) || ca < least_inside(c, a)) continue;
            const float of_b = float(ca) * scale, of_c = float(ab) * scale;
            const float share = a.share + of_b * (b.share - a.share) + of_c * (c.share - a.share);
            plot(x, y, a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z),
                 (a.colour + of_b * (b.colour - a.colour) + of_c * (c.colour - a.colour)) / share);
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

void draw_triangle(Vertex a, Vertex b, Vertex c) {
    if (is_cut(a.q, b.q, c.q)) return;
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
    if (count >= 3) fill_triangle(points[0], points[1], points[2]);
    if (count == 4) fill_triangle(points[0], points[2], points[3]);
}

void main() {
    for (uint n = gl_WorkGroupID.x; n < min(large_count, push.width * push.height); n += gl_NumWorkGroups.x) {
        const uint cell = large_cells[n];
        const Vertex top_left = vertex(cell), bottom_right = vertex(cell + push.pitch + 1u);
        draw_triangle(top_left, vertex(cell + 1u), bottom_right);
        draw_triangle(top_left, bottom_right, vertex(cell + push.pitch));
    }
}
