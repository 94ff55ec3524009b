#pragma once

#include <string>

#include "device/hand_control.hpp"
#include "player/window/persistent_device.hpp"

namespace touchable {

/// Whether a device that is held exerts forces, and what to do about it.
struct HandState {
    enum class Mood { off, on, away };
    enum class What { away, has_no_force, repositioned, on, off };
    Mood mood = Mood::off;
    What what = What::off;
    std::string words;             ///< always to be read in the picture
    std::string remark;            ///< what the person has to do (HapticDevice::prompt); empty: nothing
    bool has_to_come_out = false;  ///< `remark` is that the finger is to leave the surface first
};

/// `is_inside`: the guard keeps a finger's force back until it has been free.
HandState hand_state(const PersistentDevice& hand, const HandControl& control, bool is_inside = false);

/// What the panel shows of it.
struct HandFacts {
    std::string device;  ///< its name
    HandState state;
    double age_s = 0;            ///< of the positions; infinite: there are none
    double scene_per_metre = 1;  ///< metres of the scene that a finger goes for one of the hand
    int buttons = 0;
};

}  // namespace touchable
