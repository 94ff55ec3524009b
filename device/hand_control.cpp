// SPDX-License-Identifier: Apache-2.0
#include "device/hand.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace touchable {
namespace {

constexpr std::uint32_t first_button = 1, second_button = 2;

bool is_known(const glm::dvec3& place) {
    return std::isfinite(glm::dot(place, place));
}

}  // namespace

/// Mean position of the known fingers; nothing: none is known.
std::optional<glm::dvec3> HandControl::centre() const {
    glm::dvec3 sum(0);
    int known = 0;
    for (std::size_t finger = 0; finger < count_; ++finger)
        if (fingers_[finger].known) {
            sum += fingers_[finger].place;
            ++known;
        }
    if (known == 0) return std::nullopt;
    return sum / static_cast<double>(known);
}

/// How far the hand has moved since the clutch began: the mean over fingers known then and now, so that a
/// finger lost or found meanwhile has no effect; if there is none, over the last known positions.
glm::dvec3 HandControl::moved() const {
    glm::dvec3 known(0), seen(0);
    int count_known = 0, count_seen = 0;
    for (std::size_t finger = 0; finger < count_; ++finger) {
        const Finger& one = fingers_[finger];
        if (!one.gripped) continue;
        seen += one.place - *one.gripped;
        ++count_seen;
        if (!one.known) continue;
        known += one.place - *one.gripped;
        ++count_known;
    }
    if (count_known > 0) return known / static_cast<double>(count_known);
    return count_seen > 0 ? seen / static_cast<double>(count_seen) : seen;
}

/// Holds each finger where it is; a finger found while the others are held, where it would have been.
void HandControl::grip() {
    const glm::dvec3 way = gripped_ ? moved() : glm::dvec3(0);
    gripped_ = true;
    for (std::size_t finger = 0; finger < count_; ++finger) {
        Finger& one = fingers_[finger];
        if (!one.known || one.gripped) continue;
        one.gripped = one.place - way;
        one.goal = mapping_.workspace.to_scene(*one.gripped + offset_);
    }
}

/// Moves each finger that is inside the surface out along its pixel's ray, and the others with it. That may
/// put one of them under a cliff, which the next round corrects.
void HandControl::come_out(const SurfaceProbe& surface) {
    constexpr int rounds = 4;
    const Workspace& space = mapping_.workspace;
    const double gap = out_of_it / space.metres_per_scene_unit;
    for (std::size_t k = 0; k < rounds * count_; ++k) {
        const Finger& finger = fingers_[k % count_];
        if (!finger.known) continue;
        const glm::dvec3 goal = space.to_scene(finger.place + offset_);
        const glm::dvec3 at = goal.z < 0 ? surface.project(goal) : glm::dvec3(0);
        const std::optional<double> depth = surface.depth_under(at.x, at.y);
        if (!depth || !(at.z > *depth)) continue;
        const glm::dvec3 out = surface.unproject(at.x, at.y, std::max(*depth - gap, 0.5 * *depth));
        offset_ += (out - goal) * space.metres_per_scene_unit;
    }
}

void HandControl::go_on_from(const HandControl& before) {
    ask_force(before.force_is_asked());
    allowed_.store(before.allowed_.load(std::memory_order_relaxed), std::memory_order_relaxed);
    hold(before.held_.load(std::memory_order_relaxed));
    if (before.recentrings_.load(std::memory_order_relaxed) != before.recentred_) recentre();
    if (before.beginnings_.load(std::memory_order_relaxed) != before.begun_)
        beginnings_.fetch_add(1, std::memory_order_relaxed);
    // If the hand is away, the device's middle stays where it is in the scene.
    const glm::dvec3 hand = before.centre().value_or(glm::dvec3(0));
    const glm::dvec3 there = before.mapping_.workspace.to_scene(hand + before.offset_in_effect());
    offset_ = mapping_.workspace.to_device(there) - hand;
}

void HandControl::take_buttons(std::uint32_t buttons, bool known) {
    if ((buttons & second_button) != 0) ask_force(false);
    if (!known) {
        pressed_ = ~0U;
        return;
    }
    const std::uint32_t begun = buttons & ~pressed_;
    pressed_ = buttons;
    if ((buttons & first_button) == 0) clutch_button_ = false;
    if ((begun & first_button) != 0) presses_[0].fetch_add(1, std::memory_order_relaxed);
    if ((begun & second_button) != 0) presses_[1].fetch_add(1, std::memory_order_relaxed);
    if (!allowed_.load(std::memory_order_relaxed)) return;
    if ((begun & first_button) != 0 && (buttons & second_button) == 0) {
        clutch_button_ = force_is_asked();
        ask_force(true);
    }
}

void HandControl::to_goals(std::span<glm::dvec3> places, std::uint32_t buttons, const SurfaceProbe* surface) {
    assert(places.size() == count_);
    for (std::size_t finger = 0; finger < count_; ++finger) {
        Finger& one = fingers_[finger];
        one.known = is_known(places[finger]);
        if (!one.known) continue;
        one.place = mapping_.turn * places[finger];
        if (one.placeless >= away_ticks) one.close_gate();
    }
    const auto hand = centre();
    take_buttons(buttons, hand.has_value());
    ++figures_.ticks;
    if (!hand) ++figures_.placeless;
    absent_ticks_ = hand ? 0 : absent_ticks_ + 1;
    give_up_forces();

    const bool clutched = clutch_button_ || held_.load(std::memory_order_relaxed);
    clutched_.store(clutched, std::memory_order_relaxed);
    if (clutched && hand) grip();
    if (!clutched && gripped_ && hand) let_go(surface);
    const std::uint32_t beginnings = beginnings_.load(std::memory_order_relaxed);
    if (beginnings != begun_ && !gripped_) {
        begun_ = beginnings;
        recentred_ = recentrings_.load(std::memory_order_relaxed);
        offset_ = mapping_.offset;
        close_gates();
    }
    const std::uint32_t recentrings = recentrings_.load(std::memory_order_relaxed);
    if (recentrings != recentred_ && hand && !gripped_) {
        recentred_ = recentrings;
        offset_ = -*hand;
        close_gates();
    }
    for (std::size_t finger = 0; finger < count_; ++finger) {
        const Finger& one = fingers_[finger];
        if (one.known)
            places[finger] = gripped_ ? one.goal : mapping_.workspace.to_scene(one.place + offset_);
    }
}

void HandControl::to_device(std::span<const glm::dvec3> guarded, int ticks, std::span<glm::dvec3> newtons) {
    assert(guarded.size() == count_ && newtons.size() == count_);
    passes_ = force_is_asked() && allowed_.load(std::memory_order_relaxed) && !gripped_;
    if (!passes_) close_gates();
    if (passes_) ++figures_.exerting;
    const glm::dmat3 back = glm::transpose(mapping_.turn);
    bool waits = false;
    for (std::size_t finger = 0; finger < count_; ++finger) {
        Finger& one = fingers_[finger];
        one.placeless = one.known ? 0 : std::min(away_ticks, one.placeless + ticks);
        if (one.free) one.risen = std::min(rise_ticks, one.risen + 1);
        one.free = passes_ && (one.free || glm::dot(guarded[finger], guarded[finger]) == 0);
        waits = waits || (passes_ && one.known && !one.free);
        const double share = one.risen / double{rise_ticks};
        shares_[finger].store(share, std::memory_order_relaxed);
        // A force that is not finite is passed on, so that the device reports it.
        newtons[finger] = is_known(guarded[finger]) ? share * (back * guarded[finger]) : guarded[finger];
    }
    waits_.store(waits, std::memory_order_relaxed);
}

}  // namespace touchable
