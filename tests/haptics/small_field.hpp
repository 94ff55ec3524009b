#pragma once

#include <utility>
#include <vector>

#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable::test {

/// A pair of small frames with depths set by hand; NaN is an invalid pixel.
class SmallField {
public:
    SmallField(int width, int height, double depth, DepthSemantics semantics = DepthSemantics::range) {
        scene.width = width;
        scene.height = height;
        scene.camera = {400, 400, width / 2.0, height / 2.0};
        scene.depth.near = 40;
        scene.depth.far = 400;
        scene.depth.semantics = semantics;
        scene.default_properties = {1000, 0, 0};
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->width = width;
            frame->height = height;
            frame->coding = scene.depth;
            fill(*frame, depth);
        }
    }

    void fill(SurfaceFrame& frame, double depth) {
        depths(frame).assign(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height),
                             depth);
        refresh(frame);
    }
    void set(SurfaceFrame& frame, int x, int y, double depth) {
        depths(frame)[frame.index(x, y)] = depth;
        refresh(frame);
    }
    /// depth(x, y) over all pixels.
    template <class Function>
    void shape(SurfaceFrame& frame, Function depth) {
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x) depths(frame)[frame.index(x, y)] = depth(x, y);
        refresh(frame);
    }

    FramePair pair(double blend = 0) const { return {{0, 0, &prev}, {1, 1'000'000, &next}, blend}; }
    HeightField field(double blend = 0) const { return {scene, pair(blend)}; }

    /// One tick of one finger.
    Contact touch(FingerState& finger, const glm::dvec3& goal, double blend = 0, TouchSettings settings = {},
                  int ticks = 1) const {
        settings.metres_per_scene_unit = 0.001;
        Contact contact;
        const auto solver = TouchSolver::create(scene, settings);
        solver.value().tick(field(blend), {&goal, 1}, {&finger, 1}, {&contact, 1}, ticks);
        return contact;
    }

    Scene scene;
    SurfaceFrame prev, next;

private:
    std::vector<double>& depths(const SurfaceFrame& frame) {
        return &frame == &prev ? prev_depths_ : next_depths_;
    }
    void refresh(SurfaceFrame& frame) {
        frame.vertices = std::make_unique<ExactVertices>(scene.width, scene.height, depths(frame));
    }
    std::vector<double> prev_depths_, next_depths_;
};

}  // namespace touchable::test
