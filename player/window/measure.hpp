// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measuring in the picture: a line between two places of the surface, which follows the surface from frame to
// frame, and the texts for depths and lengths shared with the panel and the pointer's values.

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/view/pointer.hpp"
#include "player/view/view.hpp"

namespace touchable {

/// A depth, from scene units, as text: "0.0952 m".
std::string metres_in_words(double depth, const Scene& scene);
/// A depth pixel's stored code, before any filter, as text: "code 120"; for hue the colour's code. Empty if
/// the plane is.
std::string stored_in_words(const PlaneView& depth, const Scene& scene, int x, int y);
/// A length, from scene units, as text: "12.34 mm", from 10 m on "12.340 m".
std::string length_in_words(double length, const Scene& scene);
/// The depth of a finger's goal, from millimetres, as text: "4.0 deep" in the surface, or "4.0 above" if
/// negative.
std::string pressed_in_words(double millimetres);
/// A frame, numbered as `--frame` does, of `frames` frames (-1: not known).
std::string frame_in_words(std::int64_t frame, std::int64_t frames);

/// A measurement as shown in the picture and the panel.
struct MeasureFacts {
    bool is_held = false;              ///< the left button sets the ends
    std::vector<glm::dvec2> ends{};    ///< in the window, pixels: two, or those set so far
    std::optional<glm::dvec2> next{};  ///< in the window: the place that a click would take
    std::string words{};               ///< the line's length, and whether it is frozen
    bool is_frozen = false;            ///< an end currently has no depth, and keeps its last place
};

/// A line between two places of the surface, and its length in the scene. Each end belongs to a pixel of the
/// clip's depth: when the pixel's depth changes, the end moves, and the length changes. While the pixel has
/// no depth the end keeps its last place, and counts as frozen.
class MeasureTool {
public:
    bool is_held() const { return is_held_; }
    bool has_line() const { return !ends_.empty(); }
    void hold(bool held);
    /// Removes the line and puts the tool away.
    void let_go() { *this = {}; }
    /// Measures between these pixels of the depth, which must exist.
    void set(const glm::ivec2& from, const glm::ivec2& to);
    /// Takes the left button while the tool is held: a click for each end, or one stroke for both. `pointer`:
    /// window, pixels. Returns whether it used the event.
    bool take(const InputEvent& event, const glm::dvec2& pointer);

    /// The currently visible state of the clip.
    struct Seen {
        const HeightField& field;
        const FramePair& pair;
        const ViewCamera& camera;             ///< of the window's size
        PlaneView stored{};                   ///< depth of the shown frame; may be empty
        std::int64_t frame = 0;               ///< its number
        std::optional<glm::dvec2> pointer{};  ///< window, pixels; nullopt: not over the picture
    };
    /// Once a picture: sets ends at clicks on the surface, and moves both with the surface.
    void look(const Seen& seen);
    MeasureFacts facts(const ViewCamera& camera, const Scene& scene) const;

    /// News since the last call: each completed line, or why there is none.
    struct News {
        std::string words;
        bool is_bad = false;
    };
    std::vector<News> take_news() { return std::exchange(news_, {}); }

private:
    struct End {
        glm::ivec2 pixel{0};
        std::optional<glm::dvec3> point{};  // world; nullopt: not examined yet, or without depth so far
        bool is_frozen = false;
    };
    struct Click {
        glm::dvec2 at{0.0};
        bool is_second = false;  // the end of a stroke
    };
    /// The pixel that a click there takes; nullopt: no surface.
    static std::optional<glm::ivec2> pixel_at(const glm::dvec2& at, const Seen& seen);
    void take_click(const Click& click, const Seen& seen);
    static void follow(End& end, const Seen& seen);
    void tell(const Seen& seen);
    double length() const { return glm::distance(*ends_[0].point, *ends_[1].point); }

    bool is_held_ = false, is_told_ = false;
    std::optional<glm::dvec2> pressed_at_;
    std::vector<Click> clicks_;  // since the last picture
    std::vector<End> ends_;      // none, the first, or both
    End next_;                   // the end that a click under the pointer would set
    std::vector<News> news_;
};

}  // namespace touchable
