// SPDX-License-Identifier: Apache-2.0
#include "bench/real/wiping.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <utility>

#include "bench/touch/solver_ticks.hpp"
#include "device/hand_parts.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"
#include "engine/content/scenes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {
namespace {

/// From 50 mm above the plane the sensor of epfl_wiping reads at most 7 N, its tool's weight; without the
/// tool at most 5 N are left. The hands press with 20 N.
constexpr double contact_reading_n = 10, contact_n = 5;
constexpr double slow_m_per_s = 0.05;  // friction has no certain direction below it
constexpr double free_m = 0.05;
constexpr std::size_t least_ticks = 500;   // in contact, and free
constexpr int slope_ticks = 60;            // to each side: several rows of a recording
constexpr double metres_per_unit = 0.003;  // the picture of `plane` is 0.48 m wide
constexpr glm::dvec3 up{0, 0, 1}, gravity{0, 0, -9.81};

/// Velocity and acceleration: least squares of a parabola over 121 ticks (Savitzky and Golay 1964).
struct Slopes {
    glm::dvec3 velocity{0.0}, acceleration{0.0};
};
/// At a tick near the record's ends: those of the nearest one that has 60 to each side.
Slopes slopes_at(const std::vector<glm::dvec3>& places, std::size_t tick) {
    tick = std::clamp<std::size_t>(tick, slope_ticks, places.size() - slope_ticks - 1);
    constexpr double n = slope_ticks, mean_square = n * (n + 1) / 3;
    Slopes sums;
    double squares = 0, fourths = 0;
    for (int k = -slope_ticks; k <= slope_ticks; ++k) {
        const glm::dvec3& place = places[tick + static_cast<std::size_t>(k + slope_ticks) - slope_ticks];
        const double bend = k * k - mean_square;
        sums.velocity += static_cast<double>(k) * place;
        sums.acceleration += bend * place;
        squares += k * k;
        fourths += bend * bend;
    }
    return {1e3 * sums.velocity / squares, 2e6 * sums.acceleration / fourths};
}

/// The columns as stored, at 1 kHz, in the arm's base.
struct SensorLog {
    std::vector<glm::dvec3> places, forces;
    std::vector<glm::dmat3> turns;  // from the tool's axes
    std::vector<bool> held;  // the sensor's reading stands still, to the last digit: nothing was measured
};

Result<SensorLog> read_log(const std::string& file) {
    const auto read = [&](std::vector<std::string> columns) {
        return read_motion(file, {.columns = std::move(columns), .in_scene = true});
    };
    SensorLog log;
    TRY_ASSIGN(log.places, read({"x_m", "y_m", "z_m"}));
    TRY_ASSIGN(log.forces, read({"fx_N", "fy_N", "fz_N"}));
    TRY_ASSIGN(const auto real_part, read({"q0"}));
    TRY_ASSIGN(const auto imaginary, read({"q1", "q2", "q3"}));
    for (std::size_t k = 0; k < log.places.size(); ++k) {
        const glm::dvec3& i = imaginary[k];
        const glm::dquat q(real_part[k].z, i.x, i.y, i.z);
        // q and -q are the same turn: between two rows of different sign the turn stays.
        const bool between_signs = glm::length(q) < 0.99 && k > 0;
        log.turns.push_back(between_signs ? log.turns.back() : glm::mat3_cast(glm::normalize(q)));
        const bool as_before = k > 0 && log.forces[k] == log.forces[k - 1];
        const bool as_after = k + 1 < log.places.size() && log.forces[k] == log.forces[k + 1];
        log.held.push_back(as_before || as_after);
    }
    return log;
}

/// Least squares of value = zero + slope x, where values and x are vectors.
class LineFit {
public:
    void add(const glm::dvec3& value, const glm::dvec3& x) {
        values_.push_back(value);
        xs_.push_back(x);
    }
    std::size_t count() const { return values_.size(); }
    void solve() {
        const glm::dvec3 value = mean(values_), x = mean(xs_);
        double products = 0, squares = 0;
        for (std::size_t k = 0; k < count(); ++k) {
            products += glm::dot(values_[k] - value, xs_[k] - x);
            squares += glm::dot(xs_[k] - x, xs_[k] - x);
        }
        slope = squares > 0 ? products / squares : 0;
        zero = value - slope * x;
    }

    double slope = 0;
    glm::dvec3 zero{0.0};

private:
    static glm::dvec3 mean(const std::vector<glm::dvec3>& values) {
        glm::dvec3 sum(0.0);
        for (const glm::dvec3& value : values) sum += value;
        return sum / static_cast<double>(values.size());
    }
    std::vector<glm::dvec3> values_, xs_;
};

glm::dvec3 along_plane(const glm::dvec3& v) {
    return {v.x, v.y, 0};
}

/// A force along the plane over its part out of it.
glm::dvec3 slope_of(const glm::dvec3& force) {
    return along_plane(force) / force.z;
}

/// The record's forces by a finger that goes its way over a plane of such friction, in the record's axes.
Result<std::vector<glm::dvec3>> exerted_forces(const WipingRecord& record, double friction) {
    TRY_ASSIGN(const auto content, make_scene("plane", {}));
    Scene scene = content->scene();
    scene.default_properties = {scene.default_properties.stiffness, friction, friction};
    SurfaceFrame frame;
    if (auto built = make_cpu_builder(scene)->build(content->frame(0), frame); !built) return built.error();
    const FramePair pair{{0, 0, &frame}, {0, 0, &frame}};
    const HeightField field(scene, pair);
    TouchSettings settings;
    settings.metres_per_scene_unit = metres_per_unit;
    TRY_ASSIGN(const auto solver, TouchSolver::create(scene, settings));

    const auto truth = ExactSurface("plane").closest({0, 0, -1000}, {0, 0, -1000}, 0).value();
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), truth.normal));
    const glm::dmat3 to_scene(right, glm::cross(truth.normal, right), truth.normal);
    std::vector<FingerState> finger(1);
    std::vector<Contact> contact(1);
    std::vector<glm::dvec3> forces;
    for (const WipingRecord::Tick& tick : record.ticks) {
        glm::dvec3 place = tick.place;
        place.z =
            tick.pressed ? -tick.surface.z / scene.default_properties.stiffness : std::max(place.z, 0.0);
        const glm::dvec3 goal = truth.point + to_scene * place / metres_per_unit;
        solver.tick(field, std::span(&goal, 1), finger, contact);
        if (const char* fault =
                fault_of(contact[0], field, metres_per_unit, behind_tolerance(settings.metric)))
            return Error{ErrorKind::check, "tick " + std::to_string(forces.size()) + ": " + fault};
        forces.push_back(glm::transpose(to_scene) * contact[0].force);
    }
    return forces;
}

/// Of an angle in each compared tick.
void report_angles(const std::string& name, std::vector<double> degrees, Figures& figures) {
    figures.push_back({name + "_deg_median", quantile(degrees, 0.5), "deg"});
    figures.push_back({name + "_deg_p90", quantile(degrees, 0.9), "deg"});
}

/// Angles of a force to the plane's normal, and of its part along the plane to the motion's reverse.
struct Cone {
    std::vector<double> to_normal{}, to_reverse{};

    void add(const glm::dvec3& force, const glm::dvec3& velocity) {
        to_normal.push_back(degrees_between(force, up));
        to_reverse.push_back(degrees_between(along_plane(force), -velocity));
    }
    void report(const std::string& name, Figures& figures) const {
        report_angles("cone_" + name, to_normal, figures);
        report_angles("against_motion_" + name, to_reverse, figures);
    }
};

}  // namespace

Result<WipingRecord> read_wiping(const std::string& file) {
    TRY_ASSIGN(const SensorLog log, read_log(file));
    const auto refuse = [&](const std::string& what, std::size_t ticks) {
        return input_error(file + ": " + what + " for " + std::to_string(ticks) + " ms; must be " +
                           std::to_string(least_ticks) + " or more");
    };
    // The sensor is mounted half a turn about the tool's axis z.
    const auto in_tool = [&](std::size_t k) { return glm::dvec3(-1, -1, 1) * log.forces[k]; };

    std::vector<glm::dvec3> wiped;
    glm::dvec3 middle(0.0), pressing(0.0);
    for (std::size_t k = 0; k < log.places.size(); ++k) {
        if (log.held[k] || glm::length(log.forces[k]) < contact_reading_n) continue;
        wiped.push_back(log.places[k]);
        middle += log.places[k];
        pressing += log.turns[k] * in_tool(k);
    }
    if (wiped.size() < least_ticks) return refuse("presses with 10 N or more", wiped.size());
    middle /= static_cast<double>(wiped.size());
    glm::dmat3 to_plane = principal_rotation(wiped);
    if ((to_plane * pressing).z < 0) to_plane = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1) * to_plane;

    WipingRecord record;
    double squares = 0;
    for (const glm::dvec3& place : wiped) {
        const double off = (to_plane * (place - middle)).z;
        squares += off * off;
    }
    record.plane_mm = 1000 * std::sqrt(squares / static_cast<double>(wiped.size()));

    LineFit tool;  // reading = the sensor's zero + kg load, in the tool's axes
    std::vector<glm::dvec3> loads(log.places.size());
    record.ticks.resize(log.places.size());
    for (std::size_t k = 0; k < log.places.size(); ++k) {
        WipingRecord::Tick& tick = record.ticks[k];
        tick.place = to_plane * (log.places[k] - middle);
        tick.read = to_plane * (log.turns[k] * in_tool(k));
        const Slopes slopes = slopes_at(log.places, k);
        tick.velocity = along_plane(to_plane * slopes.velocity);
        tick.free = !log.held[k] && tick.place.z > free_m;
        loads[k] = glm::transpose(log.turns[k]) * (gravity - slopes.acceleration);
        if (tick.free) tool.add(in_tool(k), loads[k]);
    }
    if (tool.count() < least_ticks) return refuse("is 50 mm above what it wipes", tool.count());
    tool.solve();
    record.tool_kg = tool.slope;

    double frictions = 0, count = 0;
    for (std::size_t k = 0; k < log.places.size(); ++k) {
        WipingRecord::Tick& tick = record.ticks[k];
        tick.surface = to_plane * (log.turns[k] * (in_tool(k) - tool.zero - tool.slope * loads[k]));
        tick.pressed = tick.surface.z >= contact_n;
        tick.wiped = tick.pressed && !log.held[k] && glm::length(tick.velocity) >= slow_m_per_s;
        if (!tick.wiped) continue;
        frictions -= glm::dot(slope_of(tick.surface), glm::normalize(tick.velocity));
        ++count;
    }
    if (count < least_ticks) return refuse("presses and moves", static_cast<std::size_t>(count));
    record.friction = std::max(0.0, frictions / count);
    return record;
}

Result<void> measure_wiping(const WipingRecord& record, double others, Figures& figures) {
    TRY_ASSIGN(const auto by_others, exerted_forces(record, others));
    TRY_ASSIGN(const auto own, exerted_forces(record, record.friction));
    std::vector<double> to_reading, to_surface, to_surface_by_others, to_shaped;
    LineFit shape;  // the measured slope without friction = a tilt + dome x place
    Cone exerted, measured;
    std::vector<double> free_readings, free_rests, normal, normal_off;
    std::size_t lost = 0;
    for (std::size_t k = 0; k < record.ticks.size(); ++k) {
        const WipingRecord::Tick& tick = record.ticks[k];
        if (tick.free) {
            free_readings.push_back(glm::length(tick.read));
            free_rests.push_back(glm::length(tick.surface));
        }
        if (!tick.wiped) continue;
        lost += own[k] == glm::dvec3(0.0);
        normal.push_back(tick.surface.z);
        normal_off.push_back(std::fabs(own[k].z - tick.surface.z));
        to_reading.push_back(degrees_between(own[k], tick.read));
        to_surface.push_back(degrees_between(own[k], tick.surface));
        to_surface_by_others.push_back(degrees_between(by_others[k], tick.surface));
        exerted.add(own[k], tick.velocity);
        measured.add(tick.surface, tick.velocity);
        shape.add(slope_of(tick.surface) + record.friction * glm::normalize(tick.velocity),
                  along_plane(tick.place));
    }
    shape.solve();
    for (std::size_t k = 0; k < record.ticks.size(); ++k) {
        const WipingRecord::Tick& tick = record.ticks[k];
        if (!tick.wiped) continue;
        const glm::dvec3 shaped = slope_of(tick.surface) - shape.zero - shape.slope * along_plane(tick.place);
        to_shaped.push_back(degrees_between(slope_of(own[k]) + up, shaped + up));
    }
    const auto ticks = static_cast<double>(to_reading.size());
    figures.push_back({"ticks", ticks, ""});
    figures.push_back({"compared_pct", 100 * ticks / static_cast<double>(record.ticks.size()), "%"});
    figures.push_back({"contact_lost_ticks", static_cast<double>(lost), ""});
    figures.push_back({"normal_n_median", quantile(normal, 0.5), "N"});
    figures.push_back({"normal_off_n_median", quantile(normal_off, 0.5), "N"});
    figures.push_back({"plane_mm_rms", record.plane_mm, "mm"});
    figures.push_back({"friction", record.friction, ""});
    report_angles("force_angle", to_surface, figures);
    report_angles("force_angle_others", to_surface_by_others, figures);
    report_angles("force_angle_reading", to_reading, figures);
    report_angles("force_angle_shaped", to_shaped, figures);
    exerted.report("exerted", figures);
    measured.report("measured", figures);
    figures.push_back({"tool_kg", record.tool_kg, "kg"});
    figures.push_back({"dome_per_m", shape.slope, "1/m"});
    figures.push_back({"free_reading_n_median", quantile(free_readings, 0.5), "N"});
    figures.push_back({"free_measured_n_median", quantile(free_rests, 0.5), "N"});
    return {};
}

Result<void> measure_demonstration(const std::filesystem::path& folder, int number, Figures& figures) {
    const auto read = [&](int n) {
        return read_wiping(folder / ("circular_wiping_dataset_" + std::to_string(n) + ".csv"));
    };
    double friction = 0, count = 0;
    for (const int other : {0, 1, 2}) {
        if (other == number) continue;
        TRY_ASSIGN(const WipingRecord record, read(other));
        friction += record.friction;
        ++count;
    }
    TRY_ASSIGN(const WipingRecord record, read(number));
    return measure_wiping(record, friction / count, figures);
}

}  // namespace touchable
