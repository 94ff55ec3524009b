// SPDX-License-Identifier: Apache-2.0
#include "tests/verify/synthetic.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "engine/picture/image.hpp"
#include "tests/verify/verify_forces.hpp"

namespace touchable::verify {
namespace {

template <class Sample>
void write_plane(const std::filesystem::path& file, const std::vector<Sample>& samples, const Meaning& m,
                 int channels) {
    const PlaneView view{reinterpret_cast<const std::uint8_t*>(samples.data()),
                         static_cast<std::ptrdiff_t>(sizeof(Sample)) * m.width * channels,
                         m.width,
                         m.height,
                         static_cast<int>(sizeof(Sample)),
                         channels};
    if (const auto written = write_png(file, view); !written)
        throw std::runtime_error(written.error().message);
}

nlohmann::json range(real low, real high) {
    return {narrow(low), narrow(high)};
}

nlohmann::json depth_json(const Meaning& m) {
    static constexpr std::array<const char*, 4> kinds = {"linear", "inverse", "log", "metric"};
    nlohmann::json depth = {{"coding", kinds[static_cast<std::size_t>(m.kind)]},
                            {"semantics", m.range ? "range" : "planar"},
                            {"near", narrow(m.near)},
                            {"far", narrow(m.far)},
                            {"bits", 16},
                            {"code_max", static_cast<int>(m.code_max)}};
    if (m.kind == Meaning::Kind::metric)
        depth["scale"] = narrow(m.scale);
    else
        depth["near_is"] = m.near_is_high ? "high" : "low";
    return depth;
}

std::string scene_json(const Meaning& m) {
    const nlohmann::json scene = {
        {"touchable_scene", 1},
        {"width", m.width},
        {"height", m.height},
        {"camera", {{"fx", narrow(m.fx)}, {"fy", narrow(m.fy)}, {"cx", narrow(m.cx)}, {"cy", narrow(m.cy)}}},
        {"depth", depth_json(m)},
        {"height_map", {{"max", narrow(m.largest_height)}, {"units", "world"}, {"bits", 8}}},
        {"haptic",
         {{"stiffness", range(m.low.stiffness / 1000, m.high.stiffness / 1000)},
          {"static_friction", range(m.low.mu_static, m.high.mu_static)},
          {"dynamic_friction", range(m.low.mu_dynamic, m.high.mu_dynamic)}}},
        {"default_properties",
         {{"stiffness", narrow(m.by_default.stiffness / 1000)},
          {"static_friction", narrow(m.by_default.mu_static)},
          {"dynamic_friction", narrow(m.by_default.mu_dynamic)}}},
        {"interpolation", "linear"}};
    return scene.dump(1);
}

Vec3 closest_on_segment(const Vec3& a, const Vec3& b, const Vec3& goal) {
    const Vec3 e = b - a;
    const real t = dot(goal - a, e) / dot(e, e);
    return a + std::fmin(1, std::fmax(0, t)) * e;
}

Vec3 closest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& goal) {
    const Vec3 n = cross(b - a, c - a), flat = goal - (dot(goal - a, n) / dot(n, n)) * n;
    auto inside = [&](const Vec3& p, const Vec3& r) { return dot(cross(r - p, flat - p), n) >= 0; };
    if (inside(a, b) && inside(b, c) && inside(c, a)) return flat;
    Vec3 best = closest_on_segment(a, b, goal);
    for (const Vec3& other : {closest_on_segment(b, c, goal), closest_on_segment(c, a, goal)})
        if (length(other - goal) < length(best - goal)) best = other;
    return best;
}

}  // namespace

ExportedFrame blank_frame(int width, int height) {
    ExportedFrame frame;
    Meaning& m = frame.meaning;
    m.width = width;
    m.height = height;
    m.fx = 15;
    m.fy = 14;
    m.cx = width / 2.0L;
    m.cy = height / 2.0L - 1;
    m.near = 40;
    m.far = m.scene_far = 180;
    m.code_max = 65535;
    m.height_code_max = 255;
    m.low = {100, 0, 0};
    m.high = {10000, 0, 0};
    m.by_default = {600, 0, 0};
    const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    frame.codes.assign(count, 0);
    frame.valid.assign(count, 255);
    return frame;
}

void make_flat(ExportedFrame& frame, int code, int code_per_column, int code_per_row) {
    Meaning& m = frame.meaning;
    m.kind = Meaning::Kind::inverse;
    m.range = false;
    m.near = 50;
    m.far = m.scene_far = 200;
    for (int j = 0; j < m.height; ++j)
        for (int i = 0; i < m.width; ++i)
            frame.codes[static_cast<std::size_t>(j * m.width + i)] =
                static_cast<std::uint16_t>(code + code_per_column * i + code_per_row * j);
}

void write_frame(const std::filesystem::path& folder, const ExportedFrame& frame) {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "scene.json") << scene_json(frame.meaning);
    std::ofstream(folder / "codes.json") << nlohmann::json{{"depth", depth_json(frame.meaning)}}.dump(1);
    write_plane(folder / "codes.png", frame.codes, frame.meaning, 1);
    write_plane(folder / "valid.png", frame.valid, frame.meaning, 1);
    if (!frame.haptic.empty()) write_plane(folder / "haptic.png", frame.haptic, frame.meaning, 3);
    if (!frame.heights.empty()) {
        const std::vector<std::uint8_t> bytes(frame.heights.begin(), frame.heights.end());
        write_plane(folder / "height.png", bytes, frame.meaning, 1);
    }
}

Vec3 closest_point(const Surface& surface, const Vec3& goal) {
    Vec3 best{1e9L, 1e9L, 1e9L};
    auto consider = [&](const Vec3& p) {
        if (length(p - goal) < length(best - goal)) best = p;
    };
    for (int j = -1; j < surface.meaning().height; ++j)
        for (int i = -1; i < surface.meaning().width; ++i) {
            const Vec3 a = surface.vertex(i, j).position, c = surface.vertex(i + 1, j + 1).position;
            consider(closest_on_triangle(a, surface.vertex(i + 1, j).position, c, goal));
            consider(closest_on_triangle(a, c, surface.vertex(i, j + 1).position, goal));
        }
    return best;
}

Vec3 rounded(const Vec3& v) {
    return {narrow(v.x), narrow(v.y), narrow(v.z)};
}

Row contact_row(const Surface& surface, const Vec3& proxy, const Vec3& goal) {
    Row row;
    row.goal = rounded(goal);
    row.proxy = rounded(proxy);
    row.pixel = surface.project(row.proxy);
    row.pixel = {narrow(row.pixel.x), narrow(row.pixel.y)};
    row.touch = surface.touch_at(row.pixel);
    row.force = row.touch.stiffness * row.metres_per_unit * (row.proxy - row.goal);
    return row;
}

void write_forces(const std::filesystem::path& file, const std::vector<Row>& rows) {
    std::ofstream out(file);
    out.precision(17);
    out << "tick,time_s,finger,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,force_x,force_y,force_z,contact,"
           "pixel_x,"
           "pixel_y,stiffness,mu_static,mu_dynamic,frame_prev,frame_next,blend,guard,S,capped,share\n";
    for (const Row& r : rows) {
        out << r.tick << ',' << r.tick * 0.001 << ',' << r.finger;
        for (const Vec3& v : {r.goal, r.proxy, r.force})
            out << ',' << narrow(v.x) << ',' << narrow(v.y) << ',' << narrow(v.z);
        out << ',' << r.contact << ',' << narrow(r.pixel.x) << ',' << narrow(r.pixel.y) << ','
            << narrow(r.touch.stiffness) << ',' << narrow(r.touch.mu_static) << ','
            << narrow(r.touch.mu_dynamic) << ',' << r.prev << ',' << r.next << ',' << r.blend << ','
            << r.guard << ',' << r.metres_per_unit << ',' << r.capped << ',' << r.share << '\n';
    }
}

Outcome verify(const std::filesystem::path& folder, const std::vector<Row>& rows,
               const std::vector<std::string>& more) {
    write_forces(folder / "forces.csv", rows);
    std::vector<std::string> arguments{"--forces", folder / "forces.csv", "--frames", folder};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::ostringstream out, err;
    const int code = verify_forces(arguments, out, err);
    return {code, out.str(), err.str()};
}

}  // namespace touchable::verify
