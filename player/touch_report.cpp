#include "player/touch_report.hpp"

#include "player/machine_facts.hpp"
#include "player/touch_warnings.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

namespace {

void add_live_figures(Json& report, const TouchFigures& figures, const LiveFacts& live) {
    const auto frames = report["frames"].get<double>();
    report["late_ticks"] = live.loop.late;
    report["skipped_ticks"] = live.loop.skipped;
    report["late_us"] = to_json(figures.late_us());
    report["late_us_histogram"] = figures.late_histogram();
    report["scheduling"] = live.loop.grant.in_words();
    report["late_frames"] = live.late_frames;
    report["interrupted"] = live.interrupted;
    report["late_frames_pct"] = frames > 0 ? 100.0 * static_cast<double>(live.late_frames) / frames : 0.0;
}

}  // namespace

Json make_report(const TouchSetup& setup, const TouchFigures& figures, const LiveFacts* live,
                 const SurfacePainter* painter) {
    const std::string cpu = cpu_facts().model;
    Json report{{"format", 1},
                {"clip", setup.clip.string()},
                {"notes", setup.notes},
                {"hand", setup.hand_words},
                {"builder", setup.feed->builder_name()},
                {"builder_why", setup.feed->builder_name() == setup.builder.name ? setup.builder_why : ""},
                {"device_name", setup.feed->builder_name() == "vulkan" ? setup.gpu->name() : cpu},
                {"cpu_name", cpu},
                {"width", setup.scene.width},
                {"height", setup.scene.height},
                {"frames", setup.feed->frames()},
                {"fingers", setup.settings.fingers}};
    report.update(figures.to_json());
    report["clock"] = live ? "wall" : "virtual";
    if (!setup.device_words.empty()) report["device"] = setup.device_words;
    if (live) add_live_figures(report, figures, *live);
    report["skipped_tiles_pct"] = 100 * setup.feed->skipped_share();
    report["frame_ms"] = to_json(spread_of(setup.feed->build_ms()));
    report["stages_ms"] = {{"read", spread_of(setup.feed->read_ms()).p50},
                           {"build", spread_of(setup.feed->build_ms()).p50}};
    if (painter) {
        const std::string gpu = painter->gpu_name();
        report["painter"] = painter->name();
        report["painter_device_name"] = gpu.empty() ? cpu : gpu;
    }
    report["warnings"] = touch_warnings(report, *setup.feed, live);
    return report;
}

}  // namespace touchable
