#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <optional>

namespace touchable {

/// Tells the second of two quick presses at the same place from presses that touch.
class DoubleClick {
public:
    static constexpr double longest_s = 0.3;    ///< from press to press
    static constexpr double farthest_px = 6.0;  ///< likewise

    /// Whether the press of that moment, at that place, is a second one; a third is a first again.
    bool press(double now_s, const glm::dvec2& at) {
        const bool is_second =
            first_s_ && now_s - *first_s_ <= longest_s && glm::distance(at, at_) <= farthest_px;
        first_s_ = is_second ? std::nullopt : std::optional(now_s);
        at_ = at;
        return is_second;
    }
    /// What comes next belongs to no press before it.
    void forget() { first_s_.reset(); }

private:
    std::optional<double> first_s_;
    glm::dvec2 at_{0.0};
};

}  // namespace touchable
