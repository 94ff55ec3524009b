#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <span>

namespace touchable {

/// What a finger meets now.
struct LabelledFinger {
    glm::dvec2 pixel{0.0};               ///< of the clip
    std::optional<std::size_t> label{};  ///< there; nothing: the finger touches nothing that has one
};

/// Says a label once a finger has rested on it, and again only once that finger has left it. Times are the
/// window's own, seconds, and do not go backward.
class RestingFingers {
public:
    static constexpr double rests_s = 0.5;  ///< until a label is said
    static constexpr double grace_s = 0.2;  ///< a finger that is away for less has not left
    static constexpr double stays_s = 1.5;  ///< how long a label is shown once its finger has left

    /// `reach`: how far a finger may go in that time and still rests, pixels.
    explicit RestingFingers(double reach) : reach_(reach) {}

    /// The label that is to be said from now on, once.
    std::optional<std::size_t> take(std::span<const LabelledFinger> fingers, double now_s);
    /// That is to be read.
    std::optional<std::size_t> shown() const { return shown_; }

private:
    struct Finger {
        std::optional<std::size_t> label{};
        glm::dvec2 at{0.0};
        double since_s = 0, met_s = 0;  // it rests; it was last there
        bool is_said = false;
    };
    bool rests(Finger& finger, const LabelledFinger& now, double now_s) const;

    static constexpr std::size_t most_fingers = 16;
    double reach_;
    std::array<Finger, most_fingers> fingers_{};
    std::optional<std::size_t> shown_{};
    double shown_until_s_ = 0;
};

}  // namespace touchable
