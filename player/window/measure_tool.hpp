#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/view_camera.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

/// What the picture and the panel show of it.
struct MeasureFacts {
    bool is_held = false;              ///< the left button sets the ends
    std::vector<glm::dvec2> ends{};    ///< in the window, pixels: two, or as many as are there
    std::optional<glm::dvec2> next{};  ///< likewise: what a click under the pointer takes
    std::string words{};               ///< how long the line is, and what is not as it seems
    bool is_frozen = false;            ///< an end has no depth now, and stays where it had some
};

/// A line between two places of the surface, as long as it is in the scene. Each end is of a pixel of the
/// clip's depth: where that has another depth in another frame, the end is there, and the length another one.
/// Where it has none, the end stays where it was last, and is said to be frozen.
class MeasureTool {
public:
    bool is_held() const { return is_held_; }
    bool has_line() const { return !ends_.empty(); }
    void hold(bool held);
    /// Nothing is measured any more, and the tool is away.
    void let_go() { *this = {}; }
    /// Between these pixels of the depth from now on, which are there.
    void set(const glm::ivec2& from, const glm::ivec2& to);
    /// The left button while it is held: a click for each end, or one stroke for both. `pointer`: window,
    /// pixels. Whether the event is the tool's.
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

    /// What came of it since it was asked last: each line that has both its ends, or why there is none.
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
    /// That a click there takes; nothing: there is no surface.
    static std::optional<glm::ivec2> pixel_at(const glm::dvec2& at, const Seen& seen);
    void take_click(const Click& click, const Seen& seen);
    static void follow(End& end, const Seen& seen);
    void tell(const Seen& seen);
    double length() const;

    bool is_held_ = false, is_told_ = false;
    std::optional<glm::dvec2> pressed_at_;
    std::vector<Click> clicks_;  // that no picture has met yet
    std::vector<End> ends_;      // none, the first, or both
    End next_;                   // that a click under the pointer would set
    std::vector<News> news_;
};

}  // namespace touchable
