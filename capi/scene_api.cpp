// touch_scene_*: what pictures mean.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

#include "capi/objects.hpp"
#include "capi/scene_text.hpp"
#include "capi/status.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {

HandleTable<SceneObject>& scenes() {
    static auto& table = *new HandleTable<SceneObject>(1, Forked::usable);
    return table;
}

namespace {

/// Of a value that `validate` would not name as the program does.
Error camera_error(const char* member, const std::string& right) {
    return usage_error(std::string(member) + " of the camera is out of range; right would be " + right);
}

/// A far plane at a code's depth has that code on it, however the product of code and scale is rounded.
double far_plane(const touch_camera& camera) {
    const double on_code = std::round(camera.far_m / camera.metres_per_code) * camera.metres_per_code;
    return std::abs(on_code - camera.far_m) < 1e-9 * camera.far_m ? on_code : camera.far_m;
}

Result<Scene> scene_of(const touch_camera& camera) {
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (camera.depth_kind != TOUCH_PLANAR && camera.depth_kind != TOUCH_RANGE)
        return camera_error("depth_kind", "TOUCH_PLANAR or TOUCH_RANGE");
    if (!positive(camera.metres_per_code)) return camera_error("metres_per_code", "above 0, such as 0.001");
    if (!positive(camera.far_m)) return camera_error("far_m", "above 0, such as 10");
    Scene scene;
    scene.width = camera.width;
    scene.height = camera.height;
    if (!(camera.frames_per_second >= 0.001 && camera.frames_per_second <= 1000))
        return camera_error("frames_per_second", "0.001 to 1000");
    constexpr std::int64_t parts = 1'000'000;
    const std::int64_t rate = std::llround(camera.frames_per_second * static_cast<double>(parts));
    scene.rate = {rate / std::gcd(rate, parts), parts / std::gcd(rate, parts)};
    scene.metres_per_unit = 1;
    scene.camera = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = camera.depth_kind == TOUCH_RANGE ? DepthSemantics::range : DepthSemantics::planar;
    scene.depth.scale = camera.metres_per_code;
    scene.depth.code_max = 65535;
    scene.depth.far = far_plane(camera);
    scene.depth_bits = 16;
    scene.default_properties = {camera.stiffness_n_per_m, camera.static_friction, camera.dynamic_friction};
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid) return usage_error(valid.error().message);
    return scene;
}

touch_scene_facts facts_of(const SceneObject& object) {
    const Scene& scene = object.scene();
    touch_scene_facts facts{};
    facts.struct_size = sizeof facts;
    facts.width = scene.width;
    facts.height = scene.height;
    facts.depth_kind = scene.depth.semantics == DepthSemantics::range ? TOUCH_RANGE : TOUCH_PLANAR;
    facts.fx_px = scene.camera.fx;
    facts.fy_px = scene.camera.fy;
    facts.cx_px = scene.camera.cx;
    facts.cy_px = scene.camera.cy;
    facts.metres_per_scene_unit = scene.metres_per_unit;
    facts.near_units = scene.depth.near;
    facts.far_units = scene.depth.far;
    facts.frames_per_second = scene.rate.per_second();
    facts.hand_metres_per_scene_unit = scene.device_metres_per_unit.value_or(0);
    facts.unstated_filters = object.described.unstated.filters.any() ? 1 : 0;
    return facts;
}

/// Whether frames may lie so far from each other, where they may lie.
bool holds_frames(std::size_t stride) {
    constexpr std::size_t widest = std::size_t{1} << 20;
    return stride >= first_size<touch_frame> && stride <= widest && stride % alignof(touch_frame) == 0;
}

touch_camera default_camera() {
    constexpr double focal_length = 554.2562584220408;  // 320 / tan 30 degrees
    return {sizeof(touch_camera),
            640,
            480,
            TOUCH_PLANAR,
            focal_length,
            focal_length,
            319.5,
            239.5,
            0.001,
            10,
            30,
            600,
            0.4,
            0.3};
}

/// What frames of a recording tell of its depth; nothing where they have no surface.
Result<std::optional<MeasuredDepth>> measure(const Scene& scene, const unsigned char* frames,
                                             std::size_t stride, std::size_t count) {
    DepthEstimator estimator(scene);
    FrameScratch scratch;
    for (std::size_t k = 0; k < count && !estimator.enough(); ++k) {
        const auto* frame = reinterpret_cast<const touch_frame*>(frames + k * stride);
        auto raw = raw_frame(*frame, scene, scratch);
        if (!raw) return error_at("frame " + std::to_string(k) + " of those given", raw.error());
        estimator.add(*raw);
    }
    return estimator.measured();
}

const std::vector<float>& metres_of_codes(const SceneObject& object) {
    MetresOfCodes& table = *object.metres_of_codes;
    std::call_once(table.once, [&] {
        const DepthCoding& coding = object.scene().depth;
        std::vector<float> metres(std::size_t{1} << 16, std::numeric_limits<float>::quiet_NaN());
        for (std::size_t code = 0; code < metres.size(); ++code)
            if (const auto stored = static_cast<std::uint16_t>(code); coding.is_valid(stored))
                metres[code] = static_cast<float>(coding.depth(stored) * object.scene().metres_per_unit);
        table.metres = std::move(metres);
    });
    return table.metres;
}

void write_metres(const PlaneView& depth, const DepthCoding& coding, const std::vector<float>& metres,
                  unsigned char* rows, std::int64_t stride) {
    const bool is_wide = coding.kind != DepthCodingKind::hue && depth.bytes_per_sample == 2;
    for (int y = 0; y < depth.height; ++y) {
        unsigned char* to = rows + y * stride;
        const auto* samples = reinterpret_cast<const std::uint16_t*>(depth.row(y));
        for (int x = 0; x < depth.width; ++x, to += sizeof(float))
            std::memcpy(to, &metres[is_wide ? samples[x] : stored_code(depth, coding, x, y)], sizeof(float));
    }
}

}  // namespace
}  // namespace touchable::capi

touch_status touch_camera_defaults(touch_camera* camera, uint32_t struct_size) {
    return give_defaults(default_camera(), camera, struct_size);
}

touch_status touch_scene_from_camera(const touch_camera* camera, touch_scene* scene, touch_error* error) {
    return without_exceptions(error, [&] {
        if (!scene || !has_known_size(camera))
            return fail(error, TOUCH_USAGE,
                        "camera or scene is NULL, or struct_size is not sizeof(touch_camera)");
        auto made = scene_of(over_defaults(*camera, default_camera()));
        if (!made) return fail(error, made.error());
        auto object = std::make_shared<SceneObject>(SceneObject{std::move(*made)});
        object->described.unstated.filters = all_unstated;
        return give_handle(scenes(), std::move(object), *scene, error);
    });
}

touch_status touch_scene_from_text(const char* text, size_t length, touch_scene* scene, touch_error* error) {
    return without_exceptions(error, [&] {
        constexpr std::size_t longest = std::size_t{1} << 28;
        if (!text || !scene || length > longest)
            return fail(error, TOUCH_USAGE, "text or scene is NULL, or the text is longer than 256 MiB");
        auto described = scene_of_text({text, length});
        if (!described) return fail(error, described.error());
        auto object = std::make_shared<SceneObject>(SceneObject{std::move(*described)});
        return give_handle(scenes(), std::move(object), *scene, error);
    });
}

touch_status touch_scene_text(touch_scene scene, char* text, size_t capacity, size_t* length) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        if (!length || (!text && capacity > 0)) return TOUCH_USAGE;
        const auto use = scenes().find(scene.id);
        if (!use) return status_without(use);
        write_text(scene_to_json(use->described), text, capacity, *length);
        return TOUCH_OK;
    });
}

touch_status touch_scene_describe(touch_scene scene, touch_scene_facts* facts) {
    if (!has_known_size(facts)) return TOUCH_USAGE;
    const auto use = scenes().find(scene.id);
    if (!use) return status_without(use);
    hand_out(facts_of(*use), *facts);
    return TOUCH_OK;
}

touch_status touch_scene_destroy(touch_scene scene) {
    return end(scenes(), scene);
}

touch_status touch_scene_metres(touch_scene scene, const touch_plane* depth, float* metres,
                                int64_t stride_bytes, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        constexpr std::int64_t longest = std::int64_t{1} << 40;
        if (!depth || !depth->data || !metres)
            return fail(error, TOUCH_USAGE, "depth, its data or metres is NULL");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        const std::int64_t row = std::int64_t{use->scene().width} * std::int64_t{sizeof(float)};
        if (stride_bytes < -longest || stride_bytes > longest || std::abs(stride_bytes) < row)
            return fail(error, TOUCH_USAGE,
                        "stride_bytes is " + std::to_string(stride_bytes) + "; right would be at least " +
                            std::to_string(row));
        FrameScratch scratch;
        const auto codes = depth_codes(*depth, use->scene(), scratch);
        if (!codes) return fail(error, codes.error());
        write_metres(*codes, use->scene().depth, metres_of_codes(*use),
                     reinterpret_cast<unsigned char*>(metres), stride_bytes);
        return TOUCH_OK;
    });
}

touch_status touch_scene_with_filters(touch_scene scene, const touch_frame* frames, size_t frame_stride_bytes,
                                      size_t count, touch_scene* filtered, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!filtered || (!frames && count > 0) || (count > 1 && !holds_frames(frame_stride_bytes)))
            return fail(error, TOUCH_USAGE, "frames or filtered is NULL, or frame_stride_bytes is too small");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        Scene chosen = use->scene();
        auto measured =
            measure(chosen, reinterpret_cast<const unsigned char*>(frames), frame_stride_bytes, count);
        if (!measured) return fail(error, measured.error());
        if (auto settled = settle_filters(*measured, use->described.unstated.filters, chosen); !settled)
            return fail(error, settled.error());
        return give_handle(scenes(), std::make_shared<SceneObject>(SceneObject{std::move(chosen)}), *filtered,
                           error);
    });
}
