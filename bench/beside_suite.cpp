#include <cstdlib>
#include <memory>

#include "bench/beside/places.hpp"
#include "bench/real/built_frames.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/touch/noisy_scene.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/content/families.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

struct Beside {
    int side;
    double noise_mm;
};

/// Frames as a camera of side x side pixels stores them, 16 bits.
std::vector<RawFrame> frames_of(const AnalyticScene& content, double noise_mm) {
    const Scene& scene = content.scene();
    std::vector<RawFrame> raws;
    for (int n = 0; n < (noise_mm > 0 ? DepthEstimator::frames : 1); ++n) {
        SplitMix64 random(mix64(static_cast<std::uint64_t>(n) + 1));
        std::vector<double> depths(pixel_count(scene.width, scene.height));
        for (int y = 0; y < scene.height; ++y)
            content.row_depths(y, 0,
                               &depths[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene.width)]);
        if (noise_mm > 0)
            for (double& depth : depths) depth += noise_mm * normal(random);
        auto planes = std::make_shared<AnalyticScene::Planes>();
        RowBands rows(1);
        quantise(scene, depths, rows, *planes);
        raws.push_back(view_of(std::move(planes), scene, n));
    }
    return raws;
}

/// The forces of a finger that goes in along each place's normal, without friction.
Result<std::vector<glm::dvec3>> our_forces(Scene scene, const std::vector<RawFrame>& raws,
                                           const std::vector<BesidePlace>& places) {
    scene.default_properties = {600, 0, 0};
    TRY_ASSIGN(const auto frames, built(scene, raws));
    TouchSettings settings;
    TRY_ASSIGN(const auto solver, TouchSolver::create(scene, settings));
    const TimedFrame last{0, 0, &frames.back()};
    const HeightField field(scene, {last, last});
    std::vector<glm::dvec3> forces;
    for (const auto& [tip, outward] : places) {
        FingerState finger;
        Contact contact;
        for (int step = 60; step >= 0; --step) {  // from 6 mm above, 0.1 mm a tick
            const glm::dvec3 goal = tip / settings.metres_per_scene_unit + 0.1 * step * outward;
            solver.tick(field, {&goal, 1}, {&finger, 1}, {&contact, 1});
        }
        forces.push_back(contact.force);
    }
    return forces;
}

Result<void> measure_beside(const std::string& name, const Beside& beside, Figures& figures) {
    const char* const folder = std::getenv("TOUCHABLE_BESIDE");
    if (folder) TRY(write_exchange(folder, name, beside.side, beside.noise_mm));
    TRY_ASSIGN(const auto content, make_scene("bumps", {.width = beside.side, .height = beside.side}));
    const auto places = beside_places();
    const auto raws = frames_of(*content, beside.noise_mm);
    figures.push_back({"places", static_cast<double>(places.size()), ""});
    TRY_ASSIGN(const auto forces, our_forces(content->scene(), raws, places));
    add_angles(places, forces, "", figures);
    if (beside.noise_mm > 0) {
        TRY_ASSIGN(const auto filtered, our_forces(chosen_filters(raws, content->scene()), raws, places));
        add_angles(places, filtered, "_chosen", figures);
    }
    return folder ? add_columns(folder, name, figures) : Result<void>();
}

}  // namespace

std::vector<BenchCase> beside_cases(bool quick) {
    std::vector<BenchCase> cases;
    for (const Beside beside : {Beside{200, 0}, {400, 0}, {640, 0}, {400, 0.3}}) {
        if (quick && beside.side > 200) continue;
        const std::string name =
            "bumps-" + std::to_string(beside.side) + (beside.noise_mm > 0 ? "-noise" : "");
        cases.push_back({name, [=](Figures& figures) { return measure_beside(name, beside, figures); }});
    }
    return cases;
}

}  // namespace touchable
