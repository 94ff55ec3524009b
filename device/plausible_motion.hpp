#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// Which of a finger's places are believed. A hand moves a few metres in a second; a bit that was lost on a
/// wire moves it through the room. A place that cannot have been reached from the last one is left out, as
/// often as that comes. Where places go on from a leap in a way that a hand can move, the finger is there: it
/// has been lost then for `lost_ns`, so that whatever held it lets go before it is met anew.
class PlausibleMotion {
public:
    static constexpr double fastest = 5;                  ///< m/s
    static constexpr double longest_s = 0.01;             ///< for which a hand goes on unseen at that speed
    static constexpr double slack = 0.002;                ///< m, of any two places: noise, late stamps
    static constexpr double farthest = 5;                 ///< m from the device's centre
    static constexpr std::int64_t lost_ns = 150'000'000;  ///< longer than the guard takes to let go

    /// The place that is believed now: this one, or nothing. Times do not go back.
    std::optional<glm::dvec3> believe(const glm::dvec3& place, std::int64_t time_ns);
    /// Nothing was heard for so long that whatever comes next is new.
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
