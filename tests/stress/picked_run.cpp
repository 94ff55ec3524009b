#include "tests/stress/picked_run.hpp"

#include <ostream>

#include "tests/stress/drawn_scene.hpp"

namespace touchable::stress {

namespace {

constexpr double near = 40, far = 160;

class PickedRun final : public StressRun {
public:
    PickedRun(const PickedTouch& touch, double unit)
        : StressRun(touch.scene(unit)), touch_(touch), unit_(unit) {
        FrameMaker maker(scene_);
        maker.build(planes(touch.first), first_);
        maker.build(planes(touch.second), second_);
    }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        const PickedTick& picked = touch_.ticks[static_cast<std::size_t>(tick)];
        // Frames come and go as the picked moments say; time itself only goes on.
        pair.prev = {2 * tick, tick * tick_ns, &first_};
        pair.next = {2 * tick + 1, tick * tick_ns + 8 * tick_ns, &second_};
        pair.blend = picked.moment / 8.0;
        goals[0] = unproject(scene_.camera, picked.x / 8.0, picked.y / 8.0,
                             unit_ * far * 1.1 * picked.depth / 100.0);
    }

private:
    DrawnPlanes planes(const std::vector<std::uint8_t>& picture) const {
        DrawnPlanes planes;
        planes.codes.assign(picture.begin(), picture.end());
        if (touch_.height_share > 0) planes.heights.assign(touch_.heights.begin(), touch_.heights.end());
        return planes;
    }
    PickedTouch touch_;
    double unit_;
    SurfaceFrame first_, second_;
};

}  // namespace

Scene PickedTouch::scene(double unit) const {
    Scene scene;
    scene.width = width;
    scene.height = height;
    const double f = width * focal / 8.0;
    scene.camera = {f, f, width / 2.0 + off_axis, height / 2.0 - off_axis};
    scene.depth.semantics = semantics;
    scene.depth.near_is_high = near_is_high || kind == DepthCodingKind::metric;
    scene.depth.invalid_codes[0] = 7;
    scene.depth.invalid_code_count = 1;
    set_planes(scene, kind, unit * near, unit * far, 8);
    scene.height_coding.units = HeightUnits::world;
    scene.height_coding.max_height = unit * near * height_share / 100.0;
    scene.interpolation = hold ? FrameInterpolation::hold : FrameInterpolation::linear;
    scene.device_metres_per_unit = 0.001 / unit;
    scene.default_properties = {1000, friction / 10.0, friction / 15.0};
    return scene;
}

std::ostream& operator<<(std::ostream& out, const PickedTouch& t) {
    auto picture = [&](const char* name, const std::vector<std::uint8_t>& codes) {
        out << ", " << name;
        for (const int code : codes) out << ' ' << code;
    };
    out << t.width << 'x' << t.height << ", coding " << static_cast<int>(t.kind)
        << (t.semantics == DepthSemantics::range ? " range" : " planar")
        << (t.near_is_high ? "" : " far is high") << (t.hold ? " hold" : "") << ", focal " << t.focal
        << "/8, off axis " << t.off_axis << ", friction 0." << t.friction << ", heights " << t.height_share;
    picture("first", t.first);
    picture("second", t.second);
    picture("heights", t.heights);
    for (const PickedTick& tick : t.ticks)
        out << ", (" << tick.x << "/8 " << tick.y << "/8 at " << tick.depth << " %, " << tick.moment << "/8)";
    return out;
}

std::unique_ptr<StressRun> run_of(const PickedTouch& touch, double unit) {
    return std::make_unique<PickedRun>(touch, unit);
}

}  // namespace touchable::stress
