// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "tests/verify/certificate.hpp"
#include "tests/verify/exported_frame.hpp"

namespace touchable::verify {

/// Faults of a row.
enum class Check {
    order,        ///< every tick has every finger, in turn; S never changes
    finite,       ///< all numbers are finite
    behind,       ///< the proxy is not behind the surface
    off_surface,  ///< in contact, the proxy is on the surface
    pixel,        ///< pixel_x, pixel_y are where the proxy is seen
    properties,   ///< stiffness and friction are those of the surface there
    force,        ///< F = k S (P - G); the guard only takes away, but where it brakes
    free,         ///< out of contact P = G and F = 0
    minimum,      ///< the proxy is a minimum, or within the static friction cone
    slip,         ///< within a facet the proxy sticks, or slides straight to the dynamic cone
    count_
};
std::string_view name_of(Check check);

struct Settings {
    bool check_slip = true;  ///< only right for one step per tick and Coulomb friction
    int shown = 3;           ///< offenders listed of each kind
};

/// Coverage of the rows: a check that met nothing proves nothing.
struct Coverage {
    std::int64_t rows = 0, contacts = 0, guarded = 0, capped = 0;
    std::array<std::int64_t, 3> frictionless{}, friction{};  ///< contacts on a face, an edge, a vertex
    std::int64_t stuck = 0;                                  ///< held by friction, away from the minimum
    std::int64_t slip_checked = 0;  ///< rows whose step from the row before was checked
    std::int64_t with_height = 0;   ///< contacts on a facet with height taken off
    std::int64_t near_invalid = 0;  ///< contacts on a facet with an invalid vertex in the picture
    std::int64_t on_ring = 0;       ///< contacts on the ring's cells or outside them
    std::int64_t between = 0;       ///< rows strictly between two frames
    std::set<std::int64_t> frames;
    int fingers = 0;
    real largest_deficit = 0;      ///< of q, relative
    real largest_force_error = 0;  ///< relative
    real largest_residual = 0;     ///< way to the minimum beyond what friction holds, over |P - G|
};

struct Finding {
    std::int64_t count = 0;
    std::vector<std::string> first;
};

class Verifier {
public:
    Verifier(FrameStore& frames, Settings settings) : frames_(frames), settings_(settings) {}

    /// An error only where the frames cannot be read; what is wrong with the row is kept.
    Result<void> check(const ForceRow& row);
    /// After the last row: whether the last tick had every finger.
    void finish();

    const Coverage& coverage() const { return coverage_; }
    const Finding& finding(Check check) const { return findings_[static_cast<std::size_t>(check)]; }
    std::int64_t violations() const;
    void report(std::ostream& out) const;

private:
    /// Where a finger was at the tick before, in contact; `before` where that was inside a facet.
    struct Trail {
        Vec3 pixel;
        std::optional<Before> before;
    };

    void found(Check check, const ForceRow& row, const std::string& what);
    void check_order(const ForceRow& row);
    void check_free(const ForceRow& row, const Surface& surface);
    void check_contact(const ForceRow& row, const Surface& surface);
    bool check_place(const ForceRow& row, const Surface& surface);
    void check_force(const ForceRow& row);
    void check_properties(const ForceRow& row, const Touch& touch);
    void check_minimum(const ForceRow& row, const Star& star, real mu);
    void check_slip(const ForceRow& row, const Star& star, const Surface& surface);
    void cover(const Surface& surface, const Star& star, real mu);

    FrameStore& frames_;
    Settings settings_;
    Coverage coverage_;
    std::array<Finding, static_cast<std::size_t>(Check::count_)> findings_;
    std::optional<ForceRow> last_;
    std::optional<real> metres_per_unit_;
    std::map<int, Trail> trails_;  // by finger
};

/// The program without its main: checks a forces file against exported frames, prints what was covered and
/// what is wrong. Exit code: 0 nothing is wrong, 2 bad usage, 3 unreadable input, 6 a row is wrong or too few
/// are in contact.
int verify_forces(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace touchable::verify
