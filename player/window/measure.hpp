#pragma once

// Measuring in the picture: a line between two places of the surface, which follows the surface from frame to
// frame, and the words for depths and lengths that it, the panel and what is under the pointer share.

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
#include "player/draw/view.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

/// "0.0952 m": a depth, from scene units.
std::string metres_in_words(double depth, const Scene& scene);
/// "code 120": the code of a pixel in a depth plane as its reader gives it, before any filter; for hue the
/// code of its colour. Empty if the plane is.
std::string stored_in_words(const PlaneView& depth, const Scene& scene, int x, int y);
/// "12.34 mm", from 10 m on "12.340 m": a distance, from scene units.
std::string length_in_words(double length, const Scene& scene);
/// "4.0 in", or "4.0 above" below 0: how deep a finger's goal is in the surface, from millimetres.
std::string pressed_in_words(double millimetres);

/// What the picture and the panel show of a measurement.
struct MeasureFacts {
    bool is_held = false;              ///< the left button sets the ends
    std::vector<glm::dvec2> ends{};    ///< in the window, pixels: two, or as many as are there
    std::optional<glm::dvec2> next{};  ///< in the window: what a click under the pointer takes
    std::string words{};               ///< the length of the line, and whether it is frozen
    bool is_frozen = false;            ///< an end has no depth now, and stays where it had some
};

/// A line between two places of the surface, and its length in the scene. Each end belongs to a pixel of the
/// clip's depth: when the pixel's depth changes, the end moves, and the length changes. While the pixel has
/// no depth the end stays where it was last, and counts as frozen.
class MeasureTool {
public:
    bool is_held() const { return is_held_; }
    bool has_line() const { return !ends_.empty(); }
    void hold(bool held);
    /// Takes the line and the tool away.
    void let_go() { *this = {}; }
    /// Measures between these pixels of the depth, which exist.
    void set(const glm::ivec2& from, const glm::ivec2& to);
    /// Takes the left button while the tool is held: a click for each end, or one stroke for both. `pointer`:
    /// window, pixels. Returns whether the event was the tool's.
    bool take(const InputEvent& event, const glm::dvec2& pointer);

    /// What is seen of the clip now.
    struct Seen {
        const HeightField& field;
        const FramePair& pair;
        const ViewCamera& camera;             ///< of the window's size
        PlaneView stored{};                   ///< depth of the frame that is shown; may be empty
        std::int64_t frame = 0;               ///< its number
        std::optional<glm::dvec2> pointer{};  ///< window, pixels; nothing: it is not over the picture
    };
    /// Once a picture: sets ends where clicks meet the surface, and follows the surface with both.
    void look(const Seen& seen);
    MeasureFacts facts(const ViewCamera& camera, const Scene& scene) const;

    /// News since the last call: each line that has both its ends, or why there is none.
    struct News {
        std::string words;
        bool is_bad = false;
    };
    std::vector<News> take_news() { return std::exchange(news_, {}); }

private:
    struct End {
        glm::ivec2 pixel{0};
        std::optional<glm::dvec3> point{};  // world; nothing: it has not been looked at, or had no depth yet
        bool is_frozen = false;
    };
    struct Click {
        glm::dvec2 at{0.0};
        bool is_second = false;  // the end of a stroke
    };
    /// The pixel that a click there takes; nothing: there is no surface.
    static std::optional<glm::ivec2> pixel_at(const glm::dvec2& at, const Seen& seen);
    void take_click(const Click& click, const Seen& seen);
    static void follow(End& end, const Seen& seen);
    void tell(const Seen& seen);
    double length() const { return glm::distance(*ends_[0].point, *ends_[1].point); }

    bool is_held_ = false, is_told_ = false;
    std::optional<glm::dvec2> pressed_at_;
    std::vector<Click> clicks_;  // since the last picture
    std::vector<End> ends_;      // none, the first, or both
    End next_;                   // where a click under the pointer would set it
    std::vector<News> news_;
};

}  // namespace touchable
