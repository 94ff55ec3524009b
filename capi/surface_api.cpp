// touch_surface_*: frames in, a surface in time.
#include <limits>

#include "capi/objects.hpp"
#include "capi/status.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {

HandleTable<SurfaceObject>& surfaces() {
    static auto& table = *new HandleTable<SurfaceObject>(2, Forked::refused);
    return table;
}

namespace {

double hand_scale_of(const Scene& scene, const SurfaceFrame& first) {
    if (scene.device_metres_per_unit) return *scene.device_metres_per_unit;
    std::vector<double> depths = valid_depths(scene, first);
    return default_workspace(scene.width, scene.camera.fx, quantile(depths, 0.5)).metres_per_scene_unit;
}

touch_status push(SurfaceObject& surface, const touch_frame& frame, touch_error* error) {
    SurfaceFrame* slot = surface.timeline.acquire();
    if (!slot)
        return fail(error, TOUCH_FULL,
                    "every frame is still needed; push this one again once ticks have gone on");
    auto raw = raw_frame(frame, surface.scene, surface.scratch);
    if (!raw) return fail(error, raw.error());
    raw->epoch = surface.epoch;
    if (surface.epoch_has_ended)
        return fail(error, TOUCH_USAGE, "the epoch has ended; begin another one first");
    if (surface.newest && (raw->number <= surface.newest->number || raw->time_ns <= surface.newest->time_ns))
        return fail(error, TOUCH_USAGE, "the frame's number or time_ns is not later than the one before");
    if (auto built = surface.builder->build(*raw, *slot); !built) return fail(error, built.error());
    if (surface.hand_scale.load(std::memory_order_relaxed) == 0)
        surface.hand_scale.store(hand_scale_of(surface.scene, *slot), std::memory_order_release);
    if (auto published = surface.timeline.publish(raw->number, raw->time_ns); !published)
        return fail(error, published.error());
    surface.newest = {raw->number, raw->time_ns};
    return TOUCH_OK;
}

}  // namespace
}  // namespace touchable::capi

touch_status touch_frame_defaults(touch_frame* frame, uint32_t struct_size) {
    return give_defaults(touch_frame{}, frame, struct_size);
}

touch_status touch_surface_settings_defaults(touch_surface_settings* settings, uint32_t struct_size) {
    return give_defaults(touch_surface_settings{sizeof *settings, 1, 4, 0}, settings, struct_size);
}

touch_status touch_surface_create(touch_scene scene, const touch_surface_settings* settings,
                                  touch_surface* surface, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        touch_surface_settings wanted;
        touch_surface_settings_defaults(&wanted, sizeof wanted);
        if (!surface || (settings && !has_known_size(settings)))
            return fail(error, TOUCH_USAGE,
                        "surface is NULL, or struct_size is not sizeof(touch_surface_settings)");
        if (settings) wanted = over_defaults(*settings, wanted);
        if (wanted.threads < 1 || wanted.threads > 16)
            return fail(error, TOUCH_USAGE, "threads is out of range; right would be 1 to 16");
        if (wanted.frames < 4 || wanted.frames > 64)
            return fail(error, TOUCH_USAGE, "frames is out of range; right would be 4 to 64");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        return give_handle(surfaces(),
                           std::make_shared<SurfaceObject>(use->scene(), wanted.threads, wanted.frames),
                           *surface, error);
    });
}

touch_status touch_surface_push(touch_surface surface, const touch_frame* frame, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!has_known_size(frame))
            return fail(error, TOUCH_USAGE, "frame is NULL, or struct_size is not sizeof(touch_frame)");
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const TryLock lock(use->pushing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is pushing to this surface");
        return push(*use, *frame, error);
    });
}

touch_status touch_surface_begin_epoch(touch_surface surface, uint64_t epoch, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const TryLock lock(use->pushing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is pushing to this surface");
        if (epoch <= use->epoch || epoch == std::numeric_limits<std::uint64_t>::max())
            return fail(error, TOUCH_USAGE, "the epoch's number is not larger than the one before");
        use->timeline.begin_epoch(epoch);
        use->epoch = epoch;
        use->epoch_has_ended = false;
        use->newest.reset();
        return TOUCH_OK;
    });
}

touch_status touch_surface_end_epoch(touch_surface surface) {
    const auto use = surfaces().find(surface.id);
    if (!use) return status_without(use);
    const TryLock lock(use->pushing);
    if (!lock) return TOUCH_BUSY;
    use->timeline.end_epoch();
    use->epoch_has_ended = true;
    return TOUCH_OK;
}

touch_status touch_surface_newest_ns(touch_surface surface, int64_t* time_ns) {
    if (!time_ns) return TOUCH_USAGE;
    const auto use = surfaces().find(surface.id);
    if (!use) return status_without(use);
    *time_ns = use->timeline.newest_time();
    return TOUCH_OK;
}

touch_status touch_surface_hand_scale(touch_surface surface, double* metres_per_scene_unit,
                                      touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!metres_per_scene_unit) return fail(error, TOUCH_USAGE, "metres_per_scene_unit is NULL");
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const double scale = use->hand_scale.load(std::memory_order_acquire);
        if (scale == 0) return fail(error, TOUCH_USAGE, "no frame was pushed yet; push the first one before");
        *metres_per_scene_unit = scale;
        return TOUCH_OK;
    });
}

touch_status touch_surface_destroy(touch_surface surface) {
    return end(surfaces(), surface);
}
