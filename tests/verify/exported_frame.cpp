// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "engine/picture/image.hpp"
#include "tests/verify/exported_frame.hpp"

namespace touchable::verify {
namespace {

using Json = nlohmann::json;

/// Thrown and caught within this file only.
struct Refusal {
    std::string message;
};

real number(const Json& object, const char* member) {
    if (!object.contains(member) || !object.at(member).is_number())
        throw Refusal{std::string("member ") + member + " must be there, a number"};
    return object.at(member).get<double>();
}

const Json& object(const Json& scene, const char* member) {
    if (!scene.contains(member) || !scene.at(member).is_object())
        throw Refusal{std::string("member ") + member + " must be there, an object"};
    return scene.at(member);
}

/// True for `yes`, false for `no`.
bool either(const Json& object, const char* member, const char* yes, const char* no) {
    const std::string word = object.value(member, std::string());
    if (word != yes && word != no)
        throw Refusal{std::string("member ") + member + " must be " + yes + " or " + no};
    return word == yes;
}

void range(const Json& haptic, const char* member, real unit, real& low, real& high) {
    const Json& ends = haptic.contains(member) ? haptic.at(member) : Json();
    if (!ends.is_array() || ends.size() != 2 || !ends[0].is_number() || !ends[1].is_number())
        throw Refusal{std::string("member haptic.") + member + " must be [minimum, maximum]"};
    low = unit * ends[0].get<double>();
    high = unit * ends[1].get<double>();
}

void read_depth(const Json& depth, Meaning& m) {
    const std::string coding = depth.value("coding", std::string());
    if (coding == "linear" || coding == "hue")  // codes.png holds the codes that hues were turned into
        m.kind = Meaning::Kind::linear;
    else if (coding == "inverse")
        m.kind = Meaning::Kind::inverse;
    else if (coding == "log")
        m.kind = Meaning::Kind::log;
    else if (coding == "metric")
        m.kind = Meaning::Kind::metric;
    else
        throw Refusal{"member depth.coding must be linear, inverse, log, metric or hue"};
    m.range = either(depth, "semantics", "range", "planar");
    m.near = number(depth, "near");
    m.far = number(depth, "far");
    m.code_max = number(depth, "code_max");
    if (depth.contains("shift")) m.shift = number(depth, "shift");
    if (m.kind == Meaning::Kind::metric)
        m.scale = number(depth, "scale");
    else
        m.near_is_high = either(depth, "near_is", "high", "low");
}

/// `codes`: what their file says of them.
Meaning meaning_of(const Json& scene, const Json& codes) {
    Meaning m;
    m.width = static_cast<int>(number(scene, "width"));
    m.height = static_cast<int>(number(scene, "height"));
    if (m.width < 1 || m.height < 1 || m.width > 16384 || m.height > 16384)
        throw Refusal{"width and height must be 1 to 16384"};
    const Json& camera = object(scene, "camera");
    m.fx = number(camera, "fx");
    m.fy = number(camera, "fy");
    m.cx = number(camera, "cx");
    m.cy = number(camera, "cy");
    read_depth(object(codes, "depth"), m);
    const Json& stored = object(scene, "depth");
    m.scene_far = number(stored, "far");
    const Json& height = object(scene, "height_map");
    const real level = (m.scene_far - number(stored, "near")) / 255;
    m.largest_height = number(height, "max") * (either(height, "units", "levels", "world") ? level : 1);
    m.height_code_max = std::ldexp(1.0L, static_cast<int>(number(height, "bits"))) - 1;
    const Json& haptic = object(scene, "haptic");
    range(haptic, "stiffness", 1000, m.low.stiffness, m.high.stiffness);  // N/mm in the file
    range(haptic, "static_friction", 1, m.low.mu_static, m.high.mu_static);
    range(haptic, "dynamic_friction", 1, m.low.mu_dynamic, m.high.mu_dynamic);
    const Json& usual = object(scene, "default_properties");
    m.by_default = {usual.contains("stiffness_n_per_m") ? number(usual, "stiffness_n_per_m")
                                                        : 1000 * number(usual, "stiffness"),
                    number(usual, "static_friction"), number(usual, "dynamic_friction")};
    if (scene.contains("hole_stiffness")) m.hole_stiffness = 1000 * number(scene, "hole_stiffness");
    if (!(m.fx > 0 && m.fy > 0 && m.far > 0 && m.scene_far > 0 && m.code_max > 0))
        throw Refusal{"fx, fy, far and code_max must be greater than 0"};
    return m;
}

Result<Json> read_json(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) return input_error(file.string() + ": cannot be read: must be as it was exported");
    try {
        return Json::parse(stream);
    } catch (const Json::exception& fault) {
        return input_error(file.string() + ": " + fault.what());
    }
}

/// A plane of the scene's size with these channels and any of these sample widths, as 16-bit numbers.
Result<std::vector<std::uint16_t>> read_plane(const std::filesystem::path& file, const Meaning& m,
                                              int channels, int most_bytes) {
    auto image = read_image(file);
    if (!image) return image.error();
    if (image->width != m.width || image->height != m.height || image->channels != channels ||
        image->bytes_per_sample > most_bytes)
        return input_error(file.string() + ": must be " + std::to_string(m.width) + "x" +
                           std::to_string(m.height) + ", " + std::to_string(channels) +
                           " channel(s) of at most " + std::to_string(8 * most_bytes) + " bits");
    const auto bytes = static_cast<std::size_t>(image->bytes_per_sample);
    std::vector<std::uint16_t> samples(image->samples.size() / bytes);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (bytes == 1)
            samples[k] = image->samples[k];
        else
            std::memcpy(&samples[k], &image->samples[2 * k], 2);
    }
    return samples;
}

std::vector<std::uint8_t> narrow(const std::vector<std::uint16_t>& wide) {
    std::vector<std::uint8_t> bytes(wide.size());
    std::transform(wide.begin(), wide.end(), bytes.begin(),
                   [](std::uint16_t v) { return static_cast<std::uint8_t>(v); });
    return bytes;
}

}  // namespace

real Meaning::depth(std::uint16_t code) const {
    if (kind == Kind::metric) return scale * code;
    const real towards_near = near_is_high ? code / code_max : 1 - code / code_max;
    if (kind == Kind::linear) return far + (near - far) * towards_near;
    const real deep = far + shift, close = near + shift;
    if (kind == Kind::log) return deep * std::pow(close / deep, towards_near) - shift;
    return 1 / (1 / deep + (1 / close - 1 / deep) * towards_near) - shift;
}

Result<Meaning> read_meaning(const std::filesystem::path& folder) {
    auto scene = read_json(folder / "scene.json");
    if (!scene) return scene.error();
    auto codes = read_json(folder / "codes.json");
    if (!codes) return codes.error();
    try {
        return meaning_of(*scene, *codes);
    } catch (const Refusal& reason) {
        return input_error(folder.string() + ", scene.json and codes.json: " + reason.message);
    } catch (const Json::exception& fault) {
        return input_error(folder.string() + ", scene.json and codes.json: " + fault.what());
    }
}

Result<ExportedFrame> read_frame(const std::filesystem::path& folder) {
    auto meaning = read_meaning(folder);
    if (!meaning) return meaning.error();
    ExportedFrame frame;
    frame.meaning = *meaning;
    auto codes = read_plane(folder / "codes.png", frame.meaning, 1, 2);
    if (!codes) return codes.error();
    frame.codes = std::move(*codes);
    auto valid = read_plane(folder / "valid.png", frame.meaning, 1, 1);
    if (!valid) return valid.error();
    frame.valid = narrow(*valid);
    if (std::filesystem::exists(folder / "height.png")) {
        auto heights = read_plane(folder / "height.png", frame.meaning, 1, 2);
        if (!heights) return heights.error();
        frame.heights = std::move(*heights);
    }
    if (std::filesystem::exists(folder / "haptic.png")) {
        auto haptic = read_plane(folder / "haptic.png", frame.meaning, 3, 1);
        if (!haptic) return haptic.error();
        frame.haptic = narrow(*haptic);
    }
    for (std::size_t k = 0; k < frame.codes.size(); ++k)
        if (frame.valid[k] != 0) {
            const real nearest = frame.meaning.depth(frame.codes[k]) -
                                 (frame.heights.empty() ? 0 : frame.meaning.largest_height);
            if (!(nearest > 0) || !std::isfinite(nearest))
                return input_error((folder / "codes.png").string() + ": code " +
                                   std::to_string(frame.codes[k]) +
                                   " is valid but has no depth in front of the camera");
        }
    return frame;
}

Result<const ExportedFrame*> FrameStore::get(std::int64_t number) {
    if (auto known = frames_.find(number); known == frames_.end()) {
        auto frame = read_frame(folder_ / std::to_string(number));
        if (!frame) return frame.error();
        if (!frames_.empty() && !(frames_.begin()->second.meaning == frame->meaning))
            return input_error((folder_ / std::to_string(number) / "scene.json").string() +
                               ": must describe the same clip as the other frames");
        frames_.emplace(number, std::move(*frame));
    }
    std::erase(recent_, number);
    recent_.push_back(number);
    if (recent_.size() > kept) {
        frames_.erase(recent_.front());
        recent_.erase(recent_.begin());
    }
    return &frames_.at(number);
}

}  // namespace touchable::verify
namespace touchable::verify {
namespace {

constexpr std::array<std::string_view, 23> names = {
    "tick",       "finger",     "goal_x",     "goal_y",  "goal_z",  "proxy_x", "proxy_y",   "proxy_z",
    "force_x",    "force_y",    "force_z",    "contact", "pixel_x", "pixel_y", "stiffness", "mu_static",
    "mu_dynamic", "frame_prev", "frame_next", "blend",   "guard",   "S",       "capped"};

std::vector<std::string_view> split(std::string_view line) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    std::vector<std::string_view> cells;
    for (std::size_t start = 0;;) {
        const std::size_t comma = line.find(',', start);
        cells.push_back(line.substr(start, comma - start));
        if (comma == std::string_view::npos) return cells;
        start = comma + 1;
    }
}

}  // namespace

Error ForcesReader::fault(const std::string& what) const {
    return input_error(name_ + ": line " + std::to_string(line_) + ": " + what);
}

Result<ForcesReader> ForcesReader::open(const std::filesystem::path& file) {
    ForcesReader reader;
    reader.name_ = file.string();
    reader.stream_.open(file);
    std::string line;
    reader.line_ = 1;
    if (!reader.stream_ || !std::getline(reader.stream_, line))
        return input_error(reader.name_ + ": cannot be read: must be a file written by touch --forces");
    const auto header = split(line);
    reader.width_ = header.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
        const auto found = std::find(header.begin(), header.end(), names[k]);
        if (found == header.end()) return reader.fault("there is no column " + std::string(names[k]));
        reader.position_[k] = static_cast<std::size_t>(found - header.begin());
    }
    const auto share = std::find(header.begin(), header.end(), "share");
    if (share != header.end()) reader.share_ = static_cast<std::size_t>(share - header.begin());
    return reader;
}

Result<bool> ForcesReader::next(ForceRow& row) {
    std::string line;
    if (!std::getline(stream_, line)) return false;
    ++line_;
    const auto cells = split(line);
    if (cells.size() != width_)
        return fault("has " + std::to_string(cells.size()) + " columns, the header " +
                     std::to_string(width_));
    const auto is_number = [](std::string_view cell, double& value) {
        const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        return status == std::errc() && end == cell.data() + cell.size();
    };
    std::array<double, column_count> v{};
    for (std::size_t k = 0; k < column_count; ++k)
        if (const std::string_view cell = cells[position_[k]]; !is_number(cell, v[k]))
            return fault(std::string(names[k]) + " is \"" + std::string(cell) + "\": must be a number");
    double share = 1;
    if (share_ && !(is_number(cells[*share_], share) && share >= 0 && share <= 1))
        return fault("share must be between 0 and 1");
    auto whole = [&](std::size_t k, double most) {
        return v[k] >= 0 && v[k] <= most && v[k] == std::floor(v[k]);
    };
    for (const auto& [k, most] :
         {std::pair<std::size_t, double>{0, 1e15}, {1, 1e6}, {17, 1e15}, {18, 1e15}, {20, 4294967295.0}})
        if (!whole(k, most)) return fault(std::string(names[k]) + " must be a whole number, 0 or more");
    if (!(v[11] == 0 || v[11] == 1)) return fault("contact must be 0 or 1");
    if (!(v[22] == 0 || v[22] == 1)) return fault("capped must be 0 or 1");
    if (!(v[19] >= 0 && v[19] <= 1)) return fault("blend must be between 0 and 1");
    row = {line_,
           static_cast<std::int64_t>(v[0]),
           static_cast<int>(v[1]),
           {v[2], v[3], v[4]},
           {v[5], v[6], v[7]},
           {v[8], v[9], v[10]},
           v[11] != 0,
           v[12],
           v[13],
           v[14],
           v[15],
           v[16],
           static_cast<std::int64_t>(v[17]),
           static_cast<std::int64_t>(v[18]),
           v[19],
           v[20] != 0,
           (static_cast<std::uint32_t>(v[20]) & 96U) != 0,
           v[21],
           share,
           v[22] != 0};
    return true;
}

}  // namespace touchable::verify
namespace touchable::verify {
namespace {

struct Sample {
    real depth = 0, height = 0;
    bool valid = false;
};

Sample sample(const ExportedFrame& frame, std::size_t index) {
    const Meaning& m = frame.meaning;
    Sample s;
    s.valid = frame.valid[index] != 0;
    if (!s.valid) return s;
    s.depth = m.depth(frame.codes[index]);
    if (!frame.heights.empty()) s.height = m.largest_height * frame.heights[index] / m.height_code_max;
    return s;
}

real between(real a, real b, real t) {
    return a + t * (b - a);
}

/// Stiffness and friction of a pixel of a frame.
Touch meant(const ExportedFrame& frame, std::size_t index) {
    const Meaning& m = frame.meaning;
    if (frame.haptic.empty()) return m.by_default;
    const std::uint8_t* p = &frame.haptic[3 * index];
    return {between(m.low.stiffness, m.high.stiffness, p[0] / 255.0L),
            between(m.low.mu_static, m.high.mu_static, p[1] / 255.0L),
            between(m.low.mu_dynamic, m.high.mu_dynamic, p[2] / 255.0L)};
}

}  // namespace

Surface::Surface(const ExportedFrame& earlier, const ExportedFrame& later, real blend)
    : earlier_(earlier),
      later_(later),
      nearer_(blend < 0.5L ? earlier : later),
      meaning_(earlier.meaning),
      blend_(blend) {}

Vec3 Surface::ray(real x, real y) const {
    return {(x - meaning_.cx) / meaning_.fx, -(y - meaning_.cy) / meaning_.fy, -1};
}

ImagePosition Surface::project(const Vec3& world) const {
    const real planar = -world.z;
    return {meaning_.cx + meaning_.fx * world.x / planar, meaning_.cy - meaning_.fy * world.y / planar};
}

Vertex Surface::vertex(int i, int j) const {
    Sample s;
    if (i >= 0 && j >= 0 && i < meaning_.width && j < meaning_.height) {
        const auto index = static_cast<std::size_t>(j) * static_cast<std::size_t>(meaning_.width) +
                           static_cast<std::size_t>(i);
        const Sample a = sample(earlier_, index), b = sample(later_, index);
        if (blend_ == 0) {
            s = a;
        } else if (a.valid && b.valid) {
            s = {between(a.depth, b.depth, blend_), between(a.height, b.height, blend_), true};
        } else {
            s = &nearer_ == &earlier_ ? a : b;
        }
    }
    const real depth = s.valid ? s.depth - s.height : meaning_.scene_far;
    const Vec3 r = ray(i, j);
    const real planar = meaning_.range ? depth / length(r) : depth;
    return {planar * r, 1 / planar, s.valid, s.valid ? s.height : 0};
}

FacetId Surface::facet_id(ImagePosition at) const {
    auto cell = [](real x, int size) {
        if (x < -1) return -2;
        if (x > size) return size;
        return std::min(static_cast<int>(std::floor(x)), size - 1);
    };
    FacetId id{cell(at.x, meaning_.width), cell(at.y, meaning_.height), 0};
    const bool inside =
        id.column > -2 && id.column < meaning_.width && id.row > -2 && id.row < meaning_.height;
    if (inside && at.x - id.column < at.y - id.row) id.half = 1;
    return id;
}

Facet Surface::facet_at(ImagePosition at) const {
    const FacetId id = facet_id(at);
    const bool strip_x = id.column == -2 || id.column == meaning_.width;
    const bool strip_y = id.row == -2 || id.row == meaning_.height;
    const int i = std::max(id.column, -1), j = std::max(id.row, -1);
    const Vec3 p = vertex(i, j).position;
    Vec3 along, across;
    if (strip_x) {  // q does not change with x: a line of constant planar depth
        along = {1, 0, 0};
        across = strip_y ? Vec3{0, 1, 0} : vertex(i, j + 1).position - p;
    } else if (strip_y) {
        along = vertex(i + 1, j).position - p;
        across = {0, 1, 0};
    } else {
        along = vertex(i + 1, j + 1).position - p;
        across = (id.half == 0 ? vertex(i + 1, j) : vertex(i, j + 1)).position - p;
    }
    const Vec3 n = unit(cross(along, across));
    return {id, p, dot(n, p) < 0 ? n : -1 * n};
}

real Surface::q_at(ImagePosition at) const {
    const real x = std::clamp<real>(at.x, -1, meaning_.width),
               y = std::clamp<real>(at.y, -1, meaning_.height);
    const int i = std::min(static_cast<int>(std::floor(x)), meaning_.width - 1);
    const int j = std::min(static_cast<int>(std::floor(y)), meaning_.height - 1);
    const real a = x - i, b = y - j;
    const real start = vertex(i, j).q, end = vertex(i + 1, j + 1).q;
    if (a >= b) {
        const real corner = vertex(i + 1, j).q;
        return start + a * (corner - start) + b * (end - corner);
    }
    const real corner = vertex(i, j + 1).q;
    return start + b * (corner - start) + a * (end - corner);
}

Touch Surface::touch_of_pixel(int i, int j) const {
    const int ci = std::clamp(i, 0, meaning_.width - 1), cj = std::clamp(j, 0, meaning_.height - 1);
    const auto index = static_cast<std::size_t>(cj) * static_cast<std::size_t>(meaning_.width) +
                       static_cast<std::size_t>(ci);
    const Touch before = meant(earlier_, index), after = meant(later_, index);
    Touch t{between(before.stiffness, after.stiffness, blend_),
            between(before.mu_static, after.mu_static, blend_),
            between(before.mu_dynamic, after.mu_dynamic, blend_)};
    if (ci != i || cj != j || nearer_.valid[index] == 0) t.mu_static = t.mu_dynamic = 0;
    return t;
}

/// 1 where a pixel has no depth at this moment. One that is about to lose it, half-way between the frames,
/// lacks it more and more until then.
real Surface::lacks_depth(int i, int j) const {
    if (i < 0 || j < 0 || i >= meaning_.width || j >= meaning_.height) return 1;
    const auto index =
        static_cast<std::size_t>(j) * static_cast<std::size_t>(meaning_.width) + static_cast<std::size_t>(i);
    if (nearer_.valid[index] == 0) return 1;
    const bool is_lost = earlier_.valid[index] != 0 && later_.valid[index] == 0;
    return is_lost ? 2 * blend_ : 0;
}

/// The most that a vertex or one of the eight around it lacks.
real Surface::hole_around(int i, int j) const {
    real most = 0;
    for (int n = 0; n < 9; ++n) most = std::fmax(most, lacks_depth(i + n % 3 - 1, j + n / 3 - 1));
    return most;
}

Touch Surface::touch_at(ImagePosition at) const {
    const real x = std::clamp<real>(at.x, -1, meaning_.width),
               y = std::clamp<real>(at.y, -1, meaning_.height);
    const int i = std::min(static_cast<int>(std::floor(x)), meaning_.width - 1);
    const int j = std::min(static_cast<int>(std::floor(y)), meaning_.height - 1);
    const real a = x - i, b = y - j;
    Touch sum;
    real hole = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const int di = corner & 1, dj = corner >> 1;
        const Touch t = touch_of_pixel(i + di, j + dj);
        const real weight = (di ? a : 1 - a) * (dj ? b : 1 - b);
        sum.stiffness += weight * t.stiffness;
        sum.mu_static += weight * t.mu_static;
        sum.mu_dynamic += weight * t.mu_dynamic;
        if (meaning_.hole_stiffness) hole += weight * hole_around(i + di, j + dj);
    }
    if (meaning_.hole_stiffness) sum.stiffness = between(sum.stiffness, *meaning_.hole_stiffness, hole);
    sum.mu_dynamic = std::fmin(sum.mu_dynamic, sum.mu_static);
    return sum;
}

}  // namespace touchable::verify
