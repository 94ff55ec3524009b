#pragma once

#include "device/drivers/woodenhaptics_device.hpp"

namespace touchable {

/// The build of 2015 and 2016, as it was published, with its motors on.
inline WoodenParameters published_build() {
    WoodenParameters build;
    build.name = "WoodenHaptics";
    build.drive = true;
    build.joints = {
        {{2000, 1.0 / 16, 0.0259, 1, 0}, {2000, 1.0 / 12, 0.0259, 2, 0}, {2000, 1.0 / 12, 0.0259, 2, 6000}}};
    build.links = {0.080, 0.205, 0.245};
    build.origin = {0.220, 0, 0.080};
    build.reach = 0.1;
    build.limits = {5, 1000};
    return build;
}

}  // namespace touchable
