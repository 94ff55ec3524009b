#pragma once

#include <string>

#include "engine/scene/plane_view.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// "0.0952 m": of a depth, scene units.
std::string metres_in_words(double depth, const Scene& scene);
/// "code 120": what is stored of a pixel in a depth plane as its reader gives it, before any filter; for hue
/// the code that its colour makes. Empty where the plane is.
std::string stored_in_words(const PlaneView& depth, const Scene& scene, int x, int y);
/// Of a distance, scene units: "12.34 mm", from 10 m on "12.340 m".
std::string length_in_words(double length, const Scene& scene);
/// Of how deep a finger is meant to be in the surface, millimetres: "4.0 in"; below 0 "4.0 above".
std::string pressed_in_words(double millimetres);

}  // namespace touchable
