// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/sweep.hpp"
#include "tests/verify/exported_frame.hpp"

namespace touchable::verify {

inline double narrow(real v) {
    return static_cast<double>(v);
}

using test::Random;

/// A small camera looking at linear range codes of 16 bits from 40 to 180 units, without haptics, heights or
/// friction; stiffness 600 N/m. All codes 0, all valid.
ExportedFrame blank_frame(int width, int height);

/// Codes of a wall whose planar depth is 1 / (q + qx x + qy y): an exactly flat surface. Changes the coding
/// to inverse, planar, from near 50 to far 200.
void make_flat(ExportedFrame& frame, int code, int code_per_column, int code_per_row);

/// Writes a frame as `touchable export` does.
void write_frame(const std::filesystem::path& folder, const ExportedFrame& frame);

/// Point of the surface, picture and ring, that is closest to the goal: brute force over every triangle.
Vec3 closest_point(const Surface& surface, const Vec3& goal);

/// One line of a forces file; numbers as doubles.
struct Row {
    int tick = 0, finger = 0;
    Vec3 goal, proxy, force;
    bool contact = true;
    ImagePosition pixel;
    Touch touch;
    int prev = 0, next = 0;
    double blend = 0;
    int guard = 0;
    int capped = 0;
    double share = 1;
    double metres_per_unit = 0.001;
};

Vec3 rounded(const Vec3& v);
/// The row of a proxy at rest on the surface; proxy and goal are rounded to double, the force follows.
Row contact_row(const Surface& surface, const Vec3& proxy, const Vec3& goal);
void write_forces(const std::filesystem::path& file, const std::vector<Row>& rows);

/// Exit code and output of verify_forces.
struct Outcome {
    int code = 0;
    std::string out, err;
};
/// Runs it over these rows and the frames in `folder`, where the rows' file is written as well.
Outcome verify(const std::filesystem::path& folder, const std::vector<Row>& rows,
               const std::vector<std::string>& more = {});

}  // namespace touchable::verify
