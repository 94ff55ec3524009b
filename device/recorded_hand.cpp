#include "device/recorded_hand.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "device/finger_circle.hpp"
#include "device/hand_options.hpp"
#include "device/recorded_motion.hpp"
#include "device/surface_search.hpp"

namespace touchable {
namespace {

constexpr double nearest_share = 0.1;  // a goal stays this share of the anchor's depth in front of the camera

glm::dvec3 pushed_in(glm::dvec3 goal, double push, double nearest_z) {
    goal.z = std::min(goal.z - push, nearest_z);
    return goal;
}

/// Finds how far a motion has to be pushed in for a given share of its goals to lie under the surface.
class ContactSearch {
public:
    ContactSearch(const std::vector<glm::dvec3>& positions, const std::vector<glm::dvec3>& offsets,
                  double nearest_z, const SurfaceProbe& probe)
        : nearest_z_(nearest_z), probe_(probe) {
        // A long recording is judged by some 20 000 evenly spaced ticks.
        const std::size_t stride = positions.size() / 20000 + 1;
        for (std::size_t tick = 0; tick < positions.size(); tick += stride) {
            for (const glm::dvec3& offset : offsets) goals_.push_back(positions[tick] + offset);
        }
    }

    /// Scene units along -Z, found from steps of `step` by bisection; 0 where no goal ever is over a surface.
    double push_for(double wanted, double step) const {
        double above = 0;
        double under = 0;
        double stride = step;
        for (int doubling = 0; doubling < 24 && share_under(under) < wanted; ++doubling, stride *= 2) {
            above = under;
            under += stride;
        }
        if (share_under(under) < wanted) return 0;
        for (int doubling = 0; doubling < 24 && share_under(above) >= wanted; ++doubling, stride *= 2) {
            under = above;
            above -= stride;
        }
        while (under - above > step * 1e-6) {
            const double middle = 0.5 * (above + under);
            (share_under(middle) < wanted ? above : under) = middle;
        }
        const bool closer_above = wanted - share_under(above) < share_under(under) - wanted;
        return closer_above ? above : under;
    }

private:
    /// Of the goals over a surface, the share that lies under it.
    double share_under(double push) const {
        std::size_t over = 0;
        std::size_t under = 0;
        for (const glm::dvec3& goal : goals_) {
            const glm::dvec3 seen = probe_.project(pushed_in(goal, push, nearest_z_));
            const std::optional<double> surface = probe_.depth_under(seen.x, seen.y);
            if (!surface) continue;
            ++over;
            if (seen.z > *surface) ++under;
        }
        return over > 0 ? static_cast<double>(under) / static_cast<double>(over) : 0.0;
    }

    double nearest_z_;
    const SurfaceProbe& probe_;
    std::vector<glm::dvec3> goals_;
};

using Kind = HandKey::Kind;

constexpr std::array keys{
    HandKey{.name = "columns", .unit = "one column, or three joined by '+'", .kind = Kind::words},
    HandKey{"scale", "m per unit of the columns", -1e6, 1e6, 1},
    HandKey{"extent", "m", 0.001, 1},
    HandKey{.name = "time", .unit = "a column of seconds", .kind = Kind::words},
    HandKey{"rate", "rows per second", 0.1, 1e6},
    HandKey{"contact", "of the goals over a surface", 0.01, 0.99, 0.6},
    HandKey{"spread", "m", 0, 0.2, 0.02},
    HandKey{"depth", "mm", 0, 50},
    HandKey{.name = "space", .unit = "device or scene", .kind = Kind::words},
};

Error refusal(const std::string& what) {
    return usage_error("hand 'csv': " + what);
}

std::vector<std::string> split_at_plus(const std::string& text) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == '+') {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

Result<MotionSettings> motion_settings(const HandOptions& given) {
    if (!given.given("columns")) {
        return refusal("columns is missing; give columns=NAME (a motion in) or columns=X+Y+Z (a position)");
    }
    MotionSettings settings;
    settings.columns = split_at_plus(given.words("columns"));
    const bool position = settings.columns.size() == 3;
    if (!position && settings.columns.size() != 1)
        return refusal("columns takes one column or three, joined by '+'");
    if (given.given("time") && given.given("rate"))
        return refusal("time and rate exclude each other; give one");
    if (given.given("extent") && given.given("scale"))
        return refusal("extent and scale exclude each other; give one");
    if (given.given("extent") && !position)
        return refusal("extent needs three columns; with one, give scale");
    settings.scale = given.number("scale");
    if (settings.scale == 0) return refusal("scale is 0; give metres per unit of the columns");
    if (given.given("space") && given.words("space") != "device") {
        if (given.words("space") != "scene") return refusal("space is device or scene");
        if (!position) return refusal("space=scene needs three columns: X+Y+Z in the scene's coordinates");
        for (const char* key : {"scale", "extent", "contact"})
            if (given.given(key)) return refusal(std::string(key) + " has no say with space=scene");
        settings.in_scene = true;
    }
    if (given.given("extent")) settings.extent = given.number("extent");
    if (given.given("time")) settings.time = given.words("time");
    if (given.given("rate")) settings.rate = given.number("rate");
    return settings;
}

/// Where the options begin in "FILE[:key=value,...]": after the last ':' with a '=' behind it.
std::size_t options_colon(std::string_view description) {
    const std::size_t equals = description.rfind('=');
    return equals == std::string_view::npos ? equals : description.rfind(':', equals);
}

/// Lays a motion over the middle of the picture, pushed in until `contact` of its goals lie under the
/// surface. In its place: an hour of ticks takes 86 MB.
void place(std::vector<glm::dvec3>& motion, const std::vector<glm::dvec3>& offsets, double contact,
           double units_per_metre, const Workspace& workspace, const SurfaceProbe& probe) {
    const PixelBox picture = middle_of(probe, 1);
    const glm::dvec2 centre = 0.5 * (picture.least + picture.greatest);
    const std::optional<SurfacePoint> found = nearest_surface(probe, centre, picture);
    const double depth = found ? found->depth : device_depth(workspace);
    const glm::dvec3 anchor = probe.unproject(centre.x, centre.y, depth);

    for (glm::dvec3& p : motion) p = anchor + p * units_per_metre;
    const double nearest_z = -nearest_share * depth;
    const ContactSearch search(motion, offsets, nearest_z, probe);
    const double push = search.push_for(contact, 0.001 * units_per_metre);
    for (glm::dvec3& p : motion) p = pushed_in(p, push, nearest_z);
}

}  // namespace

void RecordedHand::goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    assert(tick >= 0 && goals.size() == offsets_.size());
    const std::size_t at = std::min(static_cast<std::size_t>(tick), positions_.size() - 1);
    for (std::size_t finger = 0; finger < goals.size(); ++finger)
        goals[finger] = positions_[at] + offsets_[finger];
    watch_.look(probe, goals);
}

Result<std::unique_ptr<Hand>> make_recorded_hand(std::string_view description, int fingers,
                                                 const Workspace& workspace, const SurfaceProbe& probe) {
    const std::size_t colon = options_colon(description);
    const std::string file(description.substr(0, colon));
    const std::string_view options = colon == std::string_view::npos ? "" : description.substr(colon + 1);
    if (file.empty()) return refusal("no file; expected csv:FILE:columns=NAME[,key=value,...]");
    const Result<HandOptions> given = HandOptions::parse("hand 'csv'", options, keys);
    if (!given) return given.error();
    const Result<MotionSettings> settings = motion_settings(*given);
    if (!settings) return settings.error();
    Result<std::vector<glm::dvec3>> motion = read_motion(file, *settings);
    if (!motion) return motion.error();

    const double units_per_metre = 1 / workspace.metres_per_scene_unit;
    std::vector<glm::dvec3> offsets;
    for (int finger = 0; finger < fingers; ++finger)
        offsets.emplace_back(finger_offset(finger, fingers, given->number("spread")) * units_per_metre, 0);
    if (!settings->in_scene)
        place(*motion, offsets, given->number("contact"), units_per_metre, workspace, probe);
    std::optional<double> deepest;
    if (given->given("depth")) deepest = given->number("depth") * 0.001;
    return std::unique_ptr<Hand>(std::make_unique<RecordedHand>(
        file, std::move(*motion), std::move(offsets), GoalWatch(workspace.metres_per_scene_unit, deepest)));
}

}  // namespace touchable
