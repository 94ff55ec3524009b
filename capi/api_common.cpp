// SPDX-License-Identifier: Apache-2.0
#include "capi/api_common.hpp"

#include <glm/geometric.hpp>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable::capi {
namespace {

touch_status status_of(const Error& error) {
    if (error.cause == Error::Cause::exists) return TOUCH_EXISTS;
    if (error.kind == ErrorKind::usage) return TOUCH_USAGE;
    if (error.kind == ErrorKind::input) return TOUCH_INPUT;
    return error.kind == ErrorKind::interrupted ? TOUCH_INTERRUPTED : TOUCH_INTERNAL;
}

/// Length of the longest prefix of whole UTF-8 characters that fits into `room`.
std::size_t whole_characters(std::string_view line, std::size_t room) {
    if (line.size() <= room) return line.size();
    while (room > 0 && (static_cast<unsigned char>(line[room]) & 0xc0U) == 0x80U) --room;
    return room;
}

constexpr int largest_size = 16384;

struct PlaneRules {
    const char* name;
    bool may_be_float;
};

Error plane_error(const char* name, const std::string& what) {
    return usage_error(std::string("the ") + name + " picture " + what);
}

std::int64_t row_bytes(const touch_plane& plane) {
    return std::int64_t{plane.width} * plane.channels * plane.sample;
}

/// Checks a plane as far as possible without its scene.
Result<void> check_plane(const touch_plane& plane, const PlaneRules& role) {
    if (plane.width < 1 || plane.width > largest_size || plane.height < 1 || plane.height > largest_size)
        return plane_error(role.name, "has an impossible size; must be 1 to 16384 pixels each way");
    if (plane.channels != 1 && plane.channels != 3)
        return plane_error(role.name, "has " + std::to_string(plane.channels) + " channels; must be 1 or 3");
    const bool is_float = plane.sample == TOUCH_F32;
    if (plane.sample != TOUCH_U8 && plane.sample != TOUCH_U16 && !is_float)
        return plane_error(role.name, "has samples of an unknown kind; must be TOUCH_U8 or TOUCH_U16");
    if (is_float && (!role.may_be_float || plane.channels != 1))
        return plane_error(role.name, "has samples of floats; only depth of one channel may have them");
    const std::int64_t stride = plane.stride_bytes;
    constexpr std::int64_t longest = std::int64_t{1} << 40;
    if (stride > longest || stride < -longest || (plane.height > 1 && std::abs(stride) < row_bytes(plane)))
        return plane_error(role.name, "has rows of " + std::to_string(row_bytes(plane)) +
                                          " bytes, but stride_bytes is " + std::to_string(stride));
    return {};
}

/// Modules read two-byte samples as uint16_t, so misaligned or bottom-up planes are copied into `packed`.
PlaneView view_of(const touch_plane& plane, std::vector<std::uint8_t>& packed) {
    PlaneView view;
    view.data = static_cast<const std::uint8_t*>(plane.data);
    view.stride = static_cast<std::ptrdiff_t>(plane.stride_bytes);
    view.width = plane.width;
    view.height = plane.height;
    view.bytes_per_sample = plane.sample;
    view.channels = plane.channels;
    const auto place =
        reinterpret_cast<std::uintptr_t>(plane.data) | static_cast<std::uintptr_t>(plane.stride_bytes);
    if (view.stride > 0 && place % static_cast<unsigned>(plane.sample) == 0) return view;
    const std::size_t bytes = view.row_bytes();
    packed.resize(bytes * static_cast<std::size_t>(view.height));
    view.copy_rows(packed.data(), bytes);
    view.data = packed.data();
    view.stride = static_cast<std::ptrdiff_t>(bytes);
    return view;
}

/// A code that means "no surface here".
std::optional<std::uint16_t> code_of_no_surface(const DepthCoding& coding) {
    if (coding.invalid_code_count > 0) return coding.invalid_codes[0];
    if (coding.valid_min > 0) return std::uint16_t{0};
    if (coding.valid_max < coding.code_max) return coding.code_max;
    return std::nullopt;
}

/// Counts depths above 0 without a code in the scene. A renderer's background is not a depth: 1e9 and beyond,
/// and 65504, the largest half, if no depth is farther (same rule for files: engine/formats).
class LostDepths {
public:
    void add(float metres) {
        if (!(metres < endless)) return;
        if (metres == largest_half) {
            ++halves_;
            return;
        }
        nearest_ = lost_ == 0 ? metres : std::min(nearest_, metres);
        farthest_ = std::max(farthest_, metres);
        ++lost_;
    }
    std::int64_t count() const { return lost_ + (farthest_ > largest_half ? halves_ : 0); }
    std::string range() const { return short_number(nearest_) + " to " + short_number(farthest_); }

private:
    static constexpr float endless = 1e9F, largest_half = 65504;
    std::int64_t lost_ = 0, halves_ = 0;
    float nearest_ = 0, farthest_ = 0;
};

/// Refuses a picture that loses most of its depths: its unit or the far plane is wrong. Fewer lost depths
/// than one pixel in 100 are no evidence.
Result<void> check_lost(const LostDepths& lost, std::int64_t kept, const touch_plane& plane,
                        const Scene& scene, double deepest) {
    if (lost.count() <= kept || lost.count() < std::int64_t{plane.width} * plane.height / 100) return {};
    const double unit = scene.metres_per_unit;
    return plane_error(
        "depth", "is of floats, which are metres, and " + std::to_string(lost.count()) + " of its " +
                     std::to_string(lost.count() + kept) + " depths lie outside the scene's " +
                     short_number(scene.depth.near * unit) + " to " + short_number(deepest * unit) +
                     " m: at " + lost.range() +
                     "; use depth / 1000 where these are millimetres, a scene with a larger far_m (and "
                     "metres_per_code, for 65535 codes to reach it), or 0 where there is to be no surface");
}

/// Metres of a sample, of which a 1 is `step_m`.
float metres_at(const touch_plane& plane, std::int64_t x, std::int64_t y, double step_m) {
    const auto* const at =
        static_cast<const unsigned char*>(plane.data) + y * plane.stride_bytes + x * plane.sample;
    float metres = 0;
    std::uint16_t code = 0;
    if (plane.sample == TOUCH_F32) return std::memcpy(&metres, at, sizeof metres), metres;
    return std::memcpy(&code, at, sizeof code), static_cast<float>(code * step_m);
}

/// By how many degrees codes turn the faces between three neighbours, on average: of some 64x64 of them.
double lost_degrees(const touch_plane& plane, const Scene& scene, const FrameScratch& scratch) {
    const int every = std::max({1, plane.width / 64, plane.height / 64});
    double degrees = 0;
    int count = 0;
    for (int y = 0; y + 1 < plane.height; y += every)
        for (int x = 0; x + 1 < plane.width; x += every) {
            glm::dvec3 given[3], kept[3];
            bool is_whole = true;
            for (int k = 0; k < 3; ++k) {
                const int column = x + (k == 1), row = y + (k == 2);
                const auto code =
                    scratch.codes[pixel_count(plane.width, row) + static_cast<std::size_t>(column)];
                const auto point = [&](double depth) {
                    return unproject(scene.camera, column, row,
                                     planar_depth(scene.camera, scene.depth.semantics, column, row, depth));
                };
                is_whole = is_whole && scene.depth.is_valid(code);
                given[k] = point(double{metres_at(plane, column, row, 0)} / scene.metres_per_unit);
                kept[k] = point(scene.depth.depth(code));
            }
            if (!is_whole) continue;
            degrees += degrees_between(glm::cross(given[1] - given[0], given[2] - given[0]),
                                       glm::cross(kept[1] - kept[0], kept[2] - kept[0]));
            ++count;
        }
    return count > 0 ? degrees / count : 0;
}

/// Converts lengths to the nearest codes; values <= 0, NaN or outside the scene's depths have no surface.
/// `lost`: number of depths (LostDepths) among them.
Result<PlaneView> codes_of_metres(const touch_plane& plane, const Scene& scene, FrameScratch& scratch,
                                  std::int64_t& lost) {
    if (scene.depth.kind == DepthCodingKind::hue || scene.depth_bits <= 8)
        return plane_error("depth", "is of floats, but the scene has depth of 8 bits; must be TOUCH_U8");
    const auto none = code_of_no_surface(scene.depth);
    if (!none)
        return plane_error("depth",
                           "is of floats, but every code of the scene is a depth, and none means no surface");
    std::vector<std::uint16_t>& codes = scratch.codes;
    codes.resize(pixel_count(plane.width, plane.height));
    // Compare as floats, because the program's far depth is a float, too. Beyond the last code there is no
    // surface.
    const double half_step = scene.depth.kind == DepthCodingKind::metric ? scene.depth.scale / 2 : 0,
                 deepest = std::min(scene.depth.far, scene.depth.deepest_depth() + half_step);
    const auto near = static_cast<float>(scene.depth.near * scene.metres_per_unit),
               far = static_cast<float>(deepest * scene.metres_per_unit);
    const double step_m = scratch.integer_scale * scene.metres_per_unit;
    std::size_t place = 0;
    LostDepths outside;
    std::int64_t kept = 0;
    for (std::int64_t y = 0; y < plane.height; ++y)
        for (std::int64_t x = 0; x < plane.width; ++x) {
            const float metres = metres_at(plane, x, y, step_m);
            const bool there = metres > 0 && metres >= near && metres <= far;
            kept += there;
            if (!there && metres > 0) outside.add(metres);
            codes[place++] =
                there ? scene.depth.code(static_cast<double>(metres) / scene.metres_per_unit) : *none;
        }
    lost = outside.count();
    TRY(check_lost(outside, kept, plane, scene, deepest));
    return plane_of_codes(codes.data(), plane.width, plane.height);
}

}  // namespace

touch_status fail(touch_error* error, touch_status status, std::string_view line) noexcept {
    constexpr std::size_t before = offsetof(touch_error, line);
    if (!error || error->struct_size <= before) return status;
    error->status = status;
    const std::size_t room = std::min<std::size_t>(error->struct_size, sizeof(touch_error)) - before - 1;
    const std::size_t length = whole_characters(line, room);
    std::replace_copy(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(length), error->line, '\n',
                      ' ');
    error->line[length] = 0;
    return status;
}

touch_status fail(touch_error* error, const Error& what) noexcept {
    return fail(error, status_of(what), what.message);
}

touch_status fail_stale(touch_error* error, const char* kind) {
    return fail(error, TOUCH_STALE,
                std::string(kind) + ": this handle was destroyed, or never was one of this kind");
}

Result<RawFrame> raw_frame(const touch_frame& frame, const Scene& scene, FrameScratch& scratch) {
    if (!has_known_size(&frame)) return usage_error("struct_size of the frame is not sizeof(touch_frame)");
    touch_frame given = over_defaults(&frame, touch_frame{});
    // Discard partly copied pointers.
    if (frame.struct_size < offsetof(touch_frame, lost_degrees)) given.lost_pixels = nullptr;
    if (frame.struct_size < sizeof given) given.lost_degrees = nullptr;
    if (given.number < 0 || !is_countable(given.number))
        return usage_error("the frame's number is out of range; must be 0 to 2^60");
    if (!is_countable(given.time_ns))
        return usage_error("the frame's time_ns is out of range; must be -2^60 to 2^60");
    if (given.lost_pixels) *given.lost_pixels = 0;
    if (given.lost_degrees) *given.lost_degrees = 0;
    RawFrame raw;
    raw.number = given.number;
    raw.time_ns = given.time_ns;
    const struct {
        const touch_plane& from;
        PlaneView& to;
        PlaneRules role;
    } planes[] = {{given.depth, raw.depth, {"depth", true}},
                  {given.colour, raw.colour, {"colour", false}},
                  {given.haptic, raw.haptic, {"haptic", false}},
                  {given.height, raw.height, {"height", false}}};
    for (std::size_t k = 0; k < std::size(planes); ++k) {
        const auto& [from, to, role] = planes[k];
        if (!from.data) continue;
        TRY(check_plane(from, role));
        // Before reading any sample: the memory may be smaller than the plane's size.
        if (from.width != scene.width || from.height != scene.height)
            return plane_error(role.name, "is " + size_text(from.width, from.height) + ", the scene says " +
                                              size_text(scene.width, scene.height));
        const bool is_integer = from.sample != TOUCH_F32;
        if (is_integer &&
            (k > 0 || scratch.integer_scale == 0 || from.sample != TOUCH_U16 || from.channels != 1)) {
            to = view_of(from, scratch.planes[k]);
            continue;
        }
        std::int64_t lost = 0;
        auto codes = codes_of_metres(from, scene, scratch, lost);
        if (given.lost_pixels) *given.lost_pixels = lost;
        TRY(assign(to, std::move(codes)));
        if (given.lost_degrees && !is_integer) *given.lost_degrees = lost_degrees(from, scene, scratch);
    }
    if (auto fits = check_raw_frame(raw, scene); !fits) return usage_error(fits.error().message);
    return raw;
}

Scene scene_of_depth(Scene scene, std::int32_t sample) {
    const double of_floats = std::exchange(scene.float_scale, 0);
    if (of_floats == 0 || sample != TOUCH_F32) return scene;
    scene.depth.scale = of_floats;
    derive_valid_range(scene.depth);
    return scene;
}

Result<PlaneView> depth_codes(const touch_plane& depth, const Scene& scene, FrameScratch& scratch) {
    touch_frame frame{};
    frame.struct_size = sizeof frame;
    frame.depth = depth;
    if (depth.sample == TOUCH_F32)
        return plane_error("depth", "is of floats, which are metres already; must be codes");
    TRY_ASSIGN(auto raw, raw_frame(frame, scene, scratch));
    return raw.depth;
}

touch_plane plane_for_program(const PlaneView& view) {
    if (view.empty()) return {};
    return {view.data, view.stride, view.width, view.height, view.bytes_per_sample, view.channels};
}

Result<SceneDescription> scene_of_text(std::string_view text) {
    TRY_ASSIGN(auto described, parse_scene(text, "the scene's text"));
    TRY_ASSIGN(auto settled, settle(described, {}));
    SceneDescription whole(std::move(settled));
    whole.unstated.filters = described.unstated.filters;
    return whole;
}

}  // namespace touchable::capi
