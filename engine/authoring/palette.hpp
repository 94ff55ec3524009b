#pragma once

#include <span>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a surface of some material is like under a finger.
struct Feel {
    HapticProperties properties{};
    int relief = 100;  ///< per cent of the heights that a clip has there
    bool operator==(const Feel& other) const {
        return properties.stiffness == other.properties.stiffness &&
               properties.static_friction == other.properties.static_friction &&
               properties.dynamic_friction == other.properties.dynamic_friction && relief == other.relief;
    }
};

/// Harder than any device: its own limit counts, which the force guard keeps to. That of the stiffest
/// generated scenes, N/mm.
inline constexpr double as_stiff_as_the_device = 2;

/// A material by its name. Dynamic friction is never above static friction.
struct PaletteMaterial {
    std::string_view name;
    double stiffness;  ///< N/mm
    double static_friction, dynamic_friction;
    int relief;  ///< per cent, estimated
    /// Where the numbers are from, or that they are estimates.
    std::string_view stiffness_source, friction_source;

    Feel feel() const { return {{stiffness * 1000, static_friction, dynamic_friction}, relief}; }
};

std::span<const PaletteMaterial> palette();

/// Null: there is none of that name.
const PaletteMaterial* find_material(std::string_view name);

/// All of them, between commas.
std::string material_names();

/// Why a name is none of the palette's: what was probably meant, and all there are.
std::string no_such_material(std::string_view name);

}  // namespace touchable
