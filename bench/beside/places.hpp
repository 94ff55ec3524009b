#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// A place where a surface is pressed. World: x right, y up, z towards the viewer; metres.
struct BesidePlace {
    glm::dvec3 tip;      ///< 0.5 mm under the surface
    glm::dvec3 outward;  ///< the surface's unit normal there: the true direction of the force
};

/// 40 x 40 places on the height field `bumps`, within 60 mm of its middle.
std::vector<BesidePlace> beside_places();

/// Appends force_angle_deg_rms<suffix> of the places in contact, contact_lost_pct<suffix>.
void add_angles(const std::vector<BesidePlace>& places, const std::vector<glm::dvec3>& forces,
                const std::string& suffix, Figures& figures);

/// Writes <name>.places.csv and, of an even grid of `side` x `side` over 200 mm, <name>.heights.csv: a line
/// "columns,rows,left,right,bottom,top", one of their values, then z of each row from the bottom up; metres.
/// `noise_mm`: standard deviation of each height.
Result<void> write_exchange(const std::filesystem::path& folder, const std::string& name, int side,
                            double noise_mm);
/// Appends add_angles of each file <name>.<program>.forces.csv there, by the program's name: the forces of
/// write_exchange's places (bench/README.md).
Result<void> add_columns(const std::filesystem::path& folder, const std::string& name, Figures& figures);

}  // namespace touchable
