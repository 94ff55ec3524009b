#include "player/window/resting_fingers.hpp"

#include <algorithm>
#include <glm/geometric.hpp>

namespace touchable {

/// Whether its label is to be said now.
bool RestingFingers::rests(Finger& finger, const LabelledFinger& now, double now_s) const {
    if (now.label && now.label == finger.label) {
        finger.met_s = now_s;
        if (glm::distance(now.pixel, finger.at) > reach_) {
            finger.at = now.pixel;
            finger.since_s = now_s;
        }
        return !finger.is_said && now_s - finger.since_s >= rests_s;
    }
    if (finger.label && now_s - finger.met_s < grace_s) return false;
    finger = {.label = now.label, .at = now.pixel, .since_s = now_s, .met_s = now_s};
    return false;
}

std::optional<std::size_t> RestingFingers::take(std::span<const LabelledFinger> fingers, double now_s) {
    std::optional<std::size_t> said;
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        Finger& finger = fingers_[k];
        if (rests(finger, k < fingers.size() ? fingers[k] : LabelledFinger{}, now_s)) {
            finger.is_said = true;
            shown_ = said = finger.label;
        }
        if (finger.is_said && finger.label == shown_)
            shown_until_s_ = std::max(shown_until_s_, now_s + stays_s);
    }
    if (shown_ && now_s >= shown_until_s_) shown_.reset();
    return said;
}

}  // namespace touchable
