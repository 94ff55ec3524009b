#include "player/window/button_signs.hpp"

#include <cmath>
#include <numbers>

#include "player/draw/colour_ramp.hpp"

namespace touchable {
namespace {

constexpr float half_turn = std::numbers::pi_v<float>;

/// Draws by tenths of a square.
struct Sketch {
    ImDrawList& list;
    ImVec2 at;
    float side;
    ImU32 ink;

    ImVec2 point(float x, float y) const { return {at.x + x * side / 10, at.y + y * side / 10}; }
    void box(float x0, float y0, float x1, float y1) const {
        list.AddRectFilled(point(x0, y0), point(x1, y1), ink);
    }
    void triangle(const ImVec2& a, const ImVec2& b, const ImVec2& c) const {
        list.AddTriangleFilled(a, b, c, ink);
    }
    void disc(float x, float y, float radius, ImU32 colour) const {
        list.AddCircleFilled(point(x, y), radius * side / 10, colour, 32);
    }
    void arc(float x, float y, float radius, float from, float to) const {
        list.PathArcTo(point(x, y), radius * side / 10, from, to, 32);
        list.PathStroke(ink, 0, 0.09F * side);
    }
};

/// A fingertip, and what it meets round it.
void draw_touch(const Sketch& sketch) {
    sketch.disc(5, 4.4F, 0.8F, sketch.ink);
    sketch.box(4.2F, 4.4F, 5.8F, 8.2F);
    sketch.arc(5, 4.4F, 2.3F, -1.17F * half_turn, 0.17F * half_turn);
}

/// An arrow nearly once round.
void draw_turn(const Sketch& sketch) {
    constexpr float radius = 2.4F, from = -0.2F * half_turn, to = 1.4F * half_turn, head = 1.2F;
    sketch.arc(5, 5, radius, from, to);
    const auto on = [&](float r, float angle) {
        return sketch.point(5 + r * std::cos(angle), 5 + r * std::sin(angle));
    };
    sketch.triangle(on(radius - head, to), on(radius + head, to), on(radius + 0.25F, to + 0.3F * half_turn));
}

/// Some of the ramp's.
void draw_colours(const Sketch& sketch) {
    sketch.disc(5, 3.6F, 1.7F, ramp_colour(0.95));
    sketch.disc(3.6F, 6.2F, 1.7F, ramp_colour(0.25));
    sketch.disc(6.4F, 6.2F, 1.7F, ramp_colour(0.6));
}

}  // namespace

void draw_sign(ButtonSign sign, const ImVec2& at, float side, ImU32 ink) {
    const Sketch sketch{*ImGui::GetWindowDrawList(), at, side, ink};
    const auto point = [&](float x, float y) { return sketch.point(x, y); };
    switch (sign) {
        case ButtonSign::pause:
            sketch.box(3, 2.7F, 4.4F, 7.3F);
            return sketch.box(5.6F, 2.7F, 7, 7.3F);
        case ButtonSign::play:
            return sketch.triangle(point(3.5F, 2.5F), point(7.5F, 5), point(3.5F, 7.5F));
        case ButtonSign::next:
            sketch.triangle(point(2.7F, 2.7F), point(6, 5), point(2.7F, 7.3F));
            return sketch.box(6.2F, 2.7F, 7.4F, 7.3F);
        case ButtonSign::previous:
            sketch.triangle(point(7.3F, 2.7F), point(4, 5), point(7.3F, 7.3F));
            return sketch.box(2.6F, 2.7F, 3.8F, 7.3F);
        case ButtonSign::home:
            sketch.triangle(point(2.4F, 5.1F), point(5, 2.5F), point(7.6F, 5.1F));
            return sketch.box(3.3F, 5, 6.7F, 7.5F);
        case ButtonSign::touch:
            return draw_touch(sketch);
        case ButtonSign::turn:
            return draw_turn(sketch);
        case ButtonSign::colours:
            return draw_colours(sketch);
        case ButtonSign::none:
            return;
    }
}

}  // namespace touchable
