#include "player/window/hand_state.hpp"

#include <utility>

namespace touchable {
namespace {

/// Of a device that has failed; nothing of one that works.
std::string words_of_fault(const PersistentDevice& hand) {
    if (hand.is_looked_for()) return "looking for the " + hand.name();
    const auto health = hand.health();
    const std::string why = health.ok() ? hand.name() + " has failed" : health.error().message;
    if (hand.is_gone()) return "no device: " + why + " - press F to look for it again";
    return health.ok() ? std::string() : "the device is away: " + why;
}

}  // namespace

HandState hand_state(const PersistentDevice& hand, const HandControl& control, bool is_inside) {
    using Mood = HandState::Mood;
    using What = HandState::What;
    if (std::string fault = words_of_fault(hand); !fault.empty())
        return {Mood::away, What::away, std::move(fault), {}};
    std::string remark = hand.prompt();
    if (remark.empty() && !(hand.age_s() <= HapticDevice::oldest_s)) remark = "no position comes from it";
    if (!remark.empty()) remark = hand.name() + ": " + remark;
    const DeviceCapabilities has = hand.capabilities();
    if (has.axes_driven == 0)
        return {Mood::off, What::has_no_force,
                "the " + hand.name() + " exerts no force: you see what you touch", remark};
    if (control.is_repositioned())
        return {Mood::off, What::repositioned, "no force while the hand is repositioned", remark};
    if (control.force_is_asked()) {
        const bool has_to_come_out = remark.empty() && (is_inside || control.waits_to_be_free());
        if (has_to_come_out) remark = "lift the finger off the surface: then it is felt";
        return {Mood::on, What::on, "forces on - F turns them off", remark, has_to_come_out};
    }
    const std::string button = has.buttons > 0 ? std::string(" or ") + has.first_button : "";
    return {Mood::off, What::off, "forces off - press F" + button, remark};
}

}  // namespace touchable
