// SPDX-License-Identifier: Apache-2.0
#include "player/window/measure.hpp"

#include <glm/geometric.hpp>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr double stroke_pixels = 6;  // a press released nearer is a click

std::string pixel_in_words(const glm::ivec2& pixel) {
    return "pixel " + std::to_string(pixel.x) + ", " + std::to_string(pixel.y);
}

}  // namespace

std::string metres_in_words(double depth, const Scene& scene) {
    return formatted("%.4f m", depth * scene.metres_per_unit);
}

std::string stored_in_words(const PlaneView& depth, const Scene& scene, int x, int y) {
    if (depth.empty()) return "";
    const std::uint16_t code = stored_code(depth, scene.depth, x, y);
    if (code == no_hue && scene.depth.kind == DepthCodingKind::hue) return "no hue";
    return "code " + std::to_string(code) + (scene.depth.is_valid(code) ? "" : ", no depth");
}

std::string length_in_words(double length, const Scene& scene) {
    const double metres = length * scene.metres_per_unit;
    if (metres >= 10) return formatted("%.3f m", metres);
    return formatted(metres < 0.1 ? "%.2f mm" : "%.1f mm", 1000 * metres);
}

std::string pressed_in_words(double millimetres) {
    return formatted("%.1f %s", std::abs(millimetres), millimetres < 0 ? "above" : "deep");
}

std::string frame_in_words(std::int64_t frame, std::int64_t frames) {
    const std::string number = "frame " + std::to_string(frame);
    return frames > 0 ? number + " (first 0, last " + std::to_string(frames - 1) + ")" : number;
}

void MeasureTool::hold(bool held) {
    is_held_ = held;
    pressed_at_.reset();
    clicks_.clear();
    if (ends_.size() == 1) ends_.clear();
}

void MeasureTool::set(const glm::ivec2& from, const glm::ivec2& to) {
    clicks_.clear();
    ends_ = {{.pixel = from}, {.pixel = to}};
    is_told_ = false;
}

bool MeasureTool::take(const InputEvent& event, const glm::dvec2& pointer) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::left_window) pressed_at_.reset();
    if (!is_held_ || event.word != "left" || event.control) return false;
    if (event.kind == Kind::pressed) {
        pressed_at_ = pointer;
        clicks_.push_back({pointer});
        return true;
    }
    if (event.kind != Kind::released || !pressed_at_) return false;
    if (glm::distance(*pressed_at_, pointer) > stroke_pixels) clicks_.push_back({pointer, true});
    pressed_at_.reset();
    return true;
}

std::optional<glm::ivec2> MeasureTool::pixel_at(const glm::dvec2& at, const Seen& seen) {
    const auto met = pick(seen.field, seen.camera, at.x, at.y);
    if (!met || !met->drawn) return std::nullopt;
    const glm::ivec2 pixel = met->pixel();
    if (!values_at(seen.field, seen.pair, pixel.x, pixel.y).valid) return std::nullopt;
    return pixel;
}

void MeasureTool::take_click(const Click& click, const Seen& seen) {
    // A stroke can only end the line begun by its own press.
    if (click.is_second && ends_.size() != 1) return;
    const auto pixel = pixel_at(click.at, seen);
    if (!pixel) {
        news_.push_back({"there is no surface to measure from", true});
        return;
    }
    if (ends_.size() == 2) ends_.clear();
    ends_.push_back({.pixel = *pixel});
    is_told_ = false;
}

void MeasureTool::follow(End& end, const Seen& seen) {
    const PixelValues values = values_at(seen.field, seen.pair, end.pixel.x, end.pixel.y);
    end.is_frozen = !values.valid;
    if (values.valid) end.point = unproject(seen.field.scene().camera, end.pixel.x, end.pixel.y, values.z);
}

void MeasureTool::look(const Seen& seen) {
    for (const Click& click : std::exchange(clicks_, {})) take_click(click, seen);
    for (End& end : ends_) follow(end, seen);
    for (const End& end : ends_)
        if (!end.point) {
            news_.push_back({"measure: " + pixel_in_words(end.pixel) + " has no depth in frame " +
                                 std::to_string(seen.frame) + "; must be a pixel of the surface",
                             true});
            return ends_.clear();
        }
    next_ = {};
    if (const auto pixel = is_held_ && seen.pointer ? pixel_at(*seen.pointer, seen) : std::nullopt) {
        next_.pixel = *pixel;
        follow(next_, seen);
    }
    if (ends_.size() == 2 && !std::exchange(is_told_, true)) tell(seen);
}

/// Reports the line with all its inputs, for later reading.
void MeasureTool::tell(const Seen& seen) {
    const Scene& scene = seen.field.scene();
    const auto words_of = [&](const End& end) {
        const std::string stored = stored_in_words(seen.stored, scene, end.pixel.x, end.pixel.y);
        return pixel_in_words(end.pixel) + " (z " + metres_in_words(-end.point->z, scene) +
               (stored.empty() ? "" : ", " + stored) + ")";
    };
    news_.push_back({length_in_words(length(), scene) + " from " + words_of(ends_[0]) + " to " +
                     words_of(ends_[1]) + ", frame " + std::to_string(seen.frame)});
}

MeasureFacts MeasureTool::facts(const ViewCamera& camera, const Scene& scene) const {
    MeasureFacts facts;
    facts.is_held = is_held_;
    const auto project = [&camera](const std::optional<glm::dvec3>& point) {
        const auto at = point ? camera.project(*point) : std::nullopt;
        return at ? std::optional(glm::dvec2(*at)) : std::nullopt;
    };
    facts.next = project(next_.point);
    if (ends_.empty() || !ends_[0].point) return facts;
    const std::optional<glm::dvec3>& other = ends_.size() == 2 ? ends_[1].point : next_.point;
    const auto from = project(ends_[0].point), to = project(other);
    if (!from || (other && !to)) return facts;
    facts.ends = {*from};
    if (!to) return facts;
    facts.ends.push_back(*to);
    facts.words = length_in_words(glm::distance(*ends_[0].point, *other), scene);
    for (const End& end : ends_) facts.is_frozen = facts.is_frozen || end.is_frozen;
    if (facts.is_frozen) facts.words += ", frozen: an end has no depth now";
    return facts;
}

}  // namespace touchable
