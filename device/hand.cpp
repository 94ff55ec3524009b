#include "device/hand.hpp"

#include "device/recorded_hand.hpp"
#include "device/scripted_hand.hpp"

namespace touchable {

Result<std::unique_ptr<Hand>> make_hand(const std::string& description, int fingers,
                                        const Workspace& workspace, const SurfaceProbe& probe) {
    constexpr int most_fingers = 256;
    if (fingers < 1 || fingers > most_fingers) {
        return usage_error("a hand has 1 to " + std::to_string(most_fingers) + " fingers, not " +
                           std::to_string(fingers));
    }
    const std::size_t colon = description.find(':');
    const std::string name = description.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : description.substr(colon + 1);
    if (name == "csv") return make_recorded_hand(rest, fingers, workspace, probe);
    if (auto hand = make_scripted_hand(name, rest, fingers, workspace, probe)) return std::move(*hand);
    return usage_error("unknown hand '" + name +
                       "'; hands are wander, stroke, press, poke, csv:FILE, rec:FILE");
}

}  // namespace touchable
