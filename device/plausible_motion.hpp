#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// Leaves out a finger's places that cannot be. A hand moves a few metres in a second; a bit that is lost on
/// a wire moves the place through the whole room. A place that the finger cannot have reached from the last
/// one is left out, however often that happens. Where all places after such a leap follow each other as a
/// hand can move, the finger is believed to be there, but only after `lost_ns`: until then its place counts
/// as unknown, so that the force guard has taken its force away before the finger appears elsewhere.
class PlausibleMotion {
public:
    static constexpr double fastest = 5;  ///< m/s
    static constexpr double longest_s =
        0.01;                               ///< a hand may have moved for at most so long between two places
    static constexpr double slack = 0.002;  ///< m, allowed between any two places: noise, late timestamps
    static constexpr double farthest = 5;   ///< m from the device's centre
    static constexpr std::int64_t lost_ns = 150'000'000;  ///< longer than the guard takes to end its force

    /// The place that is believed now: this one, or nothing. Times do not go back.
    std::optional<glm::dvec3> believe(const glm::dvec3& place, std::int64_t time_ns);
    /// Nothing was received for so long that any place may come next.
    void forget() { *this = {}; }

private:
    struct Seen {
        glm::dvec3 place{0.0};
        std::int64_t time_ns = 0;
    };
    static bool reaches(const Seen& from, const glm::dvec3& place, std::int64_t time_ns);

    std::optional<Seen> last_;       // believed
    std::optional<Seen> elsewhere_;  // newest of places that go on from a leap
    std::int64_t leapt_ns_ = 0;      // when they began
};

}  // namespace touchable
