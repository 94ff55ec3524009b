// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "device/hand_parts.hpp"
#include "device/point_motion.hpp"
#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Principal axes

glm::dmat3 scatter(std::span<const glm::dvec3> points) {
    glm::dvec3 mean(0);
    for (const glm::dvec3& p : points) mean += p;
    mean /= static_cast<double>(points.size());
    glm::dmat3 sum(0.0);
    for (const glm::dvec3& p : points) sum += glm::outerProduct(p - mean, p - mean);
    return sum;
}

/// One Jacobi rotation: makes m[p][q] zero; the columns of `vectors` turn with it.
void rotate_away(glm::dmat3& m, glm::dmat3& vectors, int p, int q) {
    if (m[p][q] == 0) return;
    const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
    const double t = (theta < 0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(t * t + 1);
    const double s = t * c;
    glm::dmat3 turn(1.0);
    turn[p][p] = turn[q][q] = c;
    turn[q][p] = s;
    turn[p][q] = -s;
    m = glm::transpose(turn) * m * turn;
    m[p][q] = m[q][p] = 0;
    vectors = vectors * turn;
}

glm::dvec3 with_fixed_sign(const glm::dvec3& axis) {
    int largest = 0;
    for (int i = 1; i < 3; ++i) {
        if (std::fabs(axis[i]) > std::fabs(axis[largest])) largest = i;
    }
    return axis[largest] < 0 ? -axis : axis;
}

// ---- Recorded motion

constexpr double ticks_per_second = 1000;
constexpr double longest_motion_s = 3600;
constexpr double farthest_motion = 10;  // device metres

/// Seconds of every row.
Result<std::vector<double>> row_times(const CsvTable& table, const MotionSettings& settings) {
    std::vector<double> times;
    if (settings.rate) {
        for (std::size_t row = 0; row < table.rows(); ++row)
            times.push_back(static_cast<double>(row) / *settings.rate);
    } else {
        if (!settings.time && !table.names("t_s"))
            return input_error(table.file() +
                               ": has no column 't_s'; name the column of seconds by time=NAME, or "
                               "give rate=HZ");
        TRY_ASSIGN(const auto column, table.column(settings.time.value_or("t_s")));
        TRY_ASSIGN(times, table.numbers(column));
    }
    if (times.size() < 2)
        return input_error(table.file() + ": has one row of data; a motion needs at least two");
    for (std::size_t row = 1; row < times.size(); ++row) {
        if (times[row] > times[row - 1]) continue;
        return input_error(table.place(row) +
                           ": time does not increase; expected seconds that grow from row to row");
    }
    if (!(times.back() - times.front() <= longest_motion_s))
        return input_error(table.file() + ": lasts more than an hour; are its times in seconds?");
    return times;
}

/// The named columns, row by row: one column in .z, three in .x .y .z.
Result<std::vector<glm::dvec3>> row_values(const CsvTable& table, const std::vector<std::string>& names) {
    std::vector<glm::dvec3> rows(table.rows(), glm::dvec3(0));
    for (std::size_t n = 0; n < names.size(); ++n) {
        TRY_ASSIGN(const auto column, table.column(names[n]));
        TRY_ASSIGN(const auto values, table.numbers(column));
        const int axis = names.size() == 1 ? 2 : static_cast<int>(n);
        for (std::size_t row = 0; row < rows.size(); ++row) {
            if (std::fabs(values[row]) > 1e9)
                return input_error(table.place(row) + ", column '" + names[n] +
                                   "': is beyond 1e9; expected a motion");
            rows[row][axis] = values[row];
        }
    }
    return rows;
}

std::vector<glm::dvec3> resample(const std::vector<double>& times, const std::vector<glm::dvec3>& rows) {
    // A last row that rounding puts a hair before its tick still counts as on it.
    const double ticks = std::floor((times.back() - times.front()) * ticks_per_second + 1e-6) + 1;
    std::vector<glm::dvec3> positions(static_cast<std::size_t>(ticks));
    std::size_t row = 0;
    for (std::size_t tick = 0; tick < positions.size(); ++tick) {
        const double time = times.front() + static_cast<double>(tick) / ticks_per_second;
        while (row + 2 < times.size() && times[row + 1] <= time) ++row;
        const double share = std::min(1.0, (time - times[row]) / (times[row + 1] - times[row]));
        positions[tick] = rows[row] + (rows[row + 1] - rows[row]) * share;
    }
    return positions;
}

/// Lays a motion in space flat before the person. Returns its larger in-plane extent.
double lay_flat(std::vector<glm::dvec3>& positions) {
    const glm::dmat3 rotation = principal_rotation(positions);
    for (glm::dvec3& p : positions) p = rotation * p;
    glm::dvec3 least = positions.front(), greatest = positions.front();
    for (const glm::dvec3& p : positions) {
        least = glm::min(least, p);
        greatest = glm::max(greatest, p);
    }
    for (glm::dvec3& p : positions) p -= 0.5 * (least + greatest);
    const glm::dvec3 size = greatest - least;
    return std::max(size.x, size.y);
}

// ---- Fingers that repeat a motion

constexpr double nearest_share = 0.1;  // share of the anchor's depth that goals stay before the camera

glm::dvec3 pushed_in(glm::dvec3 goal, double push, double nearest_z) {
    goal.z = std::min(goal.z - push, nearest_z);
    return goal;
}

/// How far a motion has to be pushed in so that the share `wanted` of its goals lies under the surface: scene
/// units along -Z, by bisection from steps of `step`; 0 if no push reaches that share.
double push_for(double wanted, double step, const std::vector<glm::dvec3>& positions,
                const std::vector<glm::dvec3>& offsets, double nearest_z, const SurfaceProbe& probe) {
    // A long recording is sampled at some 20 000 evenly spaced ticks.
    const std::size_t every = positions.size() / 20000 + 1;
    std::vector<glm::dvec3> goals;
    for (std::size_t tick = 0; tick < positions.size(); tick += every)
        for (const glm::dvec3& offset : offsets) goals.push_back(positions[tick] + offset);
    // Share of the goals over a surface that lie under it.
    const auto share_under = [&](double push) {
        std::size_t over = 0, under = 0;
        if (stop_requested()) return 0.0;
        for (const glm::dvec3& goal : goals) {
            const glm::dvec3 seen = probe.project(pushed_in(goal, push, nearest_z));
            const std::optional<double> surface = probe.depth_under(seen.x, seen.y);
            if (!surface) continue;
            ++over;
            if (seen.z > *surface) ++under;
        }
        return over > 0 ? static_cast<double>(under) / static_cast<double>(over) : 0.0;
    };
    double above = 0, under = 0, stride = step;
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

using Key = KeyedValues::Key;

constexpr std::array recorded_hand_keys{
    Key{.name = "columns", .unit = "one column, or three joined by '+'", .kind = Key::Kind::words},
    Key{"scale", "m per unit of the columns", -1e6, 1e6, 1},
    Key{"extent", "m", 0.001, 1},
    Key{.name = "time", .unit = "a column of seconds", .kind = Key::Kind::words},
    Key{"rate", "rows per second", 0.1, 1e6},
    Key{"contact", "of the goals over a surface", 0.01, 0.99, 0.6},
    Key{"spread", "m", 0, 0.2, 0.02},
    Key{"depth", "mm", 0, 50},
    Key{.name = "space", .unit = "device or scene", .kind = Key::Kind::words},
};

Error csv_hand_refusal(const std::string& what) {
    return usage_error("hand 'csv': " + what);
}

Result<MotionSettings> motion_settings(const KeyedValues& given) {
    if (!given.given("columns"))
        return csv_hand_refusal(
            "columns is missing; give columns=NAME (a motion in) or columns=X+Y+Z (a position)");
    MotionSettings settings;
    settings.columns.resize(1);
    for (const char c : given.words("columns"))
        if (c == '+')
            settings.columns.emplace_back();
        else
            settings.columns.back() += c;
    const bool position = settings.columns.size() == 3;
    if (!position && settings.columns.size() != 1)
        return csv_hand_refusal("columns takes one column or three, joined by '+'");
    if (given.given("time") && given.given("rate"))
        return csv_hand_refusal("time and rate exclude each other; give one");
    if (given.given("extent") && given.given("scale"))
        return csv_hand_refusal("extent and scale exclude each other; give one");
    if (given.given("extent") && !position)
        return csv_hand_refusal("extent needs three columns; with one, give scale");
    settings.scale = given.number("scale");
    if (settings.scale == 0) return csv_hand_refusal("scale is 0; give metres per unit of the columns");
    if (given.given("space") && given.words("space") != "device") {
        if (given.words("space") != "scene") return csv_hand_refusal("space is device or scene");
        if (!position)
            return csv_hand_refusal("space=scene needs three columns: X+Y+Z in the scene's coordinates");
        for (const char* key : {"scale", "extent", "contact"})
            if (given.given(key)) return csv_hand_refusal(std::string(key) + " has no say with space=scene");
        settings.in_scene = true;
    }
    if (given.given("extent")) settings.extent = given.number("extent");
    if (given.given("time")) settings.time = given.words("time");
    if (given.given("rate")) settings.rate = given.number("rate");
    return settings;
}

/// Fingers that repeat a recorded motion, one copy each; after its end they rest at the last position.
class RecordedHand final : public Hand {
public:
    /// `positions`: of the hand's centre, one per tick, world, scene units; `offsets`: of the fingers from
    /// it; `file`: source of the motion.
    RecordedHand(std::string file, std::vector<glm::dvec3> positions, std::vector<glm::dvec3> offsets,
                 const GoalWatch& watch)
        : file_(std::move(file)),
          positions_(std::move(positions)),
          offsets_(std::move(offsets)),
          watch_(watch) {}

    int fingers() const override { return static_cast<int>(offsets_.size()); }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override {
        assert(tick >= 0 && goals.size() == offsets_.size());
        const std::size_t at = std::min(static_cast<std::size_t>(tick), positions_.size() - 1);
        for (std::size_t finger = 0; finger < goals.size(); ++finger)
            goals[finger] = positions_[at] + offsets_[finger];
        watch_.look(probe, goals);
    }
    std::optional<std::int64_t> ticks() const override {
        return static_cast<std::int64_t>(positions_.size());
    }
    std::optional<std::string> file() const override { return file_; }
    std::vector<std::string> remarks() const override { return watch_.remarks(); }

private:
    std::string file_;
    std::vector<glm::dvec3> positions_;
    std::vector<glm::dvec3> offsets_;
    GoalWatch watch_;
};

/// Lays a motion over the middle of the picture, pushed in until the share `contact` of its goals lies under
/// the surface. Works in place: an hour of ticks takes 86 MB.
void place_motion(std::vector<glm::dvec3>& motion, const std::vector<glm::dvec3>& offsets, double contact,
                  double units_per_metre, const Workspace& workspace, const SurfaceProbe& probe) {
    const HandArea picture = middle_of(probe, 1);
    const glm::dvec2 centre = 0.5 * (picture.least + picture.greatest);
    const double depth = start_depth(probe, centre, picture, workspace);
    const glm::dvec3 anchor = probe.unproject(centre.x, centre.y, depth);

    for (glm::dvec3& p : motion) p = anchor + p * units_per_metre;
    const double nearest_z = -nearest_share * depth;
    const double push = push_for(contact, 0.001 * units_per_metre, motion, offsets, nearest_z, probe);
    for (glm::dvec3& p : motion) p = pushed_in(p, push, nearest_z);
}

}  // namespace

// ---- Principal axes

glm::dmat3 principal_rotation(std::span<const glm::dvec3> points) {
    glm::dmat3 m = scatter(points);
    glm::dmat3 vectors(1.0);
    constexpr int sweeps = 16;  // quadratic convergence: six or seven sweeps reach the last bit
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        rotate_away(m, vectors, 0, 1);
        rotate_away(m, vectors, 0, 2);
        rotate_away(m, vectors, 1, 2);
    }
    std::array<int, 3> order{0, 1, 2};
    std::ranges::stable_sort(order, [&](int a, int b) { return m[a][a] > m[b][b]; });
    const glm::dvec3 x = with_fixed_sign(glm::normalize(vectors[order[0]]));
    const glm::dvec3 y = with_fixed_sign(glm::normalize(vectors[order[1]]));
    return glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
}

// ---- Recorded motion

Result<std::vector<glm::dvec3>> read_motion(const std::string& file, const MotionSettings& settings) {
    TRY_ASSIGN(const auto table, CsvTable::read(file));
    TRY_ASSIGN(const auto rows, row_values(table, settings.columns));
    TRY_ASSIGN(const auto times, row_times(table, settings));

    std::vector<glm::dvec3> positions = resample(times, rows);
    if (settings.in_scene) return positions;
    double scale = settings.scale;
    if (settings.columns.size() == 1) {
        scale = -scale;  // in is away from the person
    } else {
        const double in_plane = lay_flat(positions);
        if (settings.extent && !(in_plane > 0))
            return input_error(file +
                               ": does not move, so that extent= has nothing to scale; give scale= instead");
        if (settings.extent) scale = *settings.extent / in_plane;
    }
    for (glm::dvec3& p : positions) {
        p *= scale;
        if (std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) <= farthest_motion) continue;
        return input_error(file + ": moves more than 10 m; give scale= as metres per unit of the columns");
    }
    return positions;
}

// ---- Fingers that repeat a motion

Result<std::unique_ptr<Hand>> make_recorded_hand(std::string_view description, int fingers,
                                                 const Workspace& workspace, const SurfaceProbe& probe) {
    const auto [name, options] = KeyedValues::file_and_pairs(description);
    const std::string file(name);
    if (file.empty()) return csv_hand_refusal("no file; expected csv:FILE:columns=NAME[,key=value,...]");
    TRY_ASSIGN(const auto given, KeyedValues::parse("hand 'csv'", options, recorded_hand_keys));
    TRY_ASSIGN(const auto settings, motion_settings(given));
    TRY_ASSIGN(auto motion, read_motion(file, settings));

    const double units_per_metre = 1 / workspace.metres_per_scene_unit;
    std::vector<glm::dvec3> offsets;
    for (int finger = 0; finger < fingers; ++finger)
        offsets.emplace_back(finger_offset(finger, fingers, given.number("spread")) * units_per_metre, 0);
    if (!settings.in_scene)
        place_motion(motion, offsets, given.number("contact"), units_per_metre, workspace, probe);
    std::optional<double> deepest;
    if (given.given("depth")) deepest = given.number("depth") * 0.001;
    return std::make_unique<RecordedHand>(file, std::move(motion), std::move(offsets),
                                          GoalWatch(workspace.metres_per_scene_unit, deepest));
}

}  // namespace touchable
