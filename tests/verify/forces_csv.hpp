#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "tests/verify/geometry.hpp"

namespace touchable::verify {

/// One tick of one finger as `touchable touch --forces` writes it: world axes, scene units, newtons, N/m.
struct ForceRow {
    std::int64_t line = 0;  ///< of the file, from 1
    std::int64_t tick = 0;
    int finger = 0;
    Vec3 goal, proxy, force;
    bool contact = false;
    real pixel_x = 0, pixel_y = 0;
    real stiffness = 0, mu_static = 0, mu_dynamic = 0;
    std::int64_t frame_prev = 0, frame_next = 0;
    real blend = 0;
    bool guarded = false;      ///< the guard changed the force
    bool braked = false;       ///< and added some: a damper's or the passivity controller's (bits 32, 64)
    real metres_per_unit = 0;  ///< S
    real share = 1;       ///< of the force, that was sent to the hand; files of older versions do not say
    bool capped = false;  ///< the solver ended at its event limit: on the surface, but not yet at the minimum
};

/// Reads a forces file row by row. Columns are found by name; all but `share` must be there, others are
/// ignored.
class ForcesReader {
public:
    static Result<ForcesReader> open(const std::filesystem::path& file);
    /// False at the end of the file.
    Result<bool> next(ForceRow& row);

private:
    static constexpr std::size_t column_count = 23;
    Error fault(const std::string& what) const;

    std::string name_;
    std::ifstream stream_;
    std::int64_t line_ = 0;
    std::array<std::size_t, column_count> position_{};  // of each wanted column in a line
    std::optional<std::size_t> share_;                  // likewise
    std::size_t width_ = 0;                             // columns of a line
};

}  // namespace touchable::verify
