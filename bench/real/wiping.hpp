// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// A surface wiped by a hand that leads a robot arm, tick by tick of 1 ms, with the forces that the arm's
/// sensor measured. Metres and newtons, in the axes of the plane that was wiped: z out of the surface, from
/// the middle of the places in contact.
struct WipingRecord {
    struct Tick {
        glm::dvec3 place{0.0};
        glm::dvec3 velocity{0.0};  ///< m/s, along the plane
        glm::dvec3 read{0.0};      ///< the sensor's reading: a force on the tool
        glm::dvec3 surface{
            0.0};              ///< the reading without the tool's weight and inertia, and the sensor's zero
        bool pressed = false;  ///< in contact
        bool wiped = false;    ///< in contact, moving, and measured
        bool free = false;     ///< far above the plane, and measured
    };
    std::vector<Tick> ticks;
    double plane_mm = 0;  ///< RMS distance from the plane in contact
    double tool_kg = 0;   ///< what hangs on the sensor: its weight and inertia off the plane
    double friction = 0;  ///< mean of the force against the motion over the normal force
};

/// Reads a recording with the columns of shared/data/haptics/epfl_wiping: t_s; x_m, y_m, z_m; the tool's
/// orientation q0 (real part) to q3 in the arm's base; fx_N, fy_N, fz_N.
Result<WipingRecord> read_wiping(const std::string& file);

/// Moves a finger over a plane as the record's hand went, as deep as its normal force over the stiffness, and
/// compares the forces (bench/README.md). `others`: the friction of other records.
Result<void> measure_wiping(const WipingRecord& record, double others, Figures& figures);

/// The same for demonstration `number`, 0 to 3, of epfl_wiping. The others' friction is that of 0 to 2: the
/// forces of 3 are a copy of those of 1 (its authors' load_wiping_dataset.m), so they are not its hand's.
Result<void> measure_demonstration(const std::filesystem::path& folder, int number, Figures& figures);

}  // namespace touchable
