#include "player/window/panel_facts.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/number_words.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "player/draw/surface_pick.hpp"
#include "player/window/pixel_words.hpp"

namespace touchable {
namespace {

/// What is under the pointer, to be read at a glance.
PlaceFacts place_facts(const OpenedClip& clip, const WatchedMoment& moment, const HeightField& field,
                       const ViewCamera& camera) {
    const auto pointer = clip.fingers().looked_at();
    if (!pointer) return {};
    const auto met = pick(field, camera, pointer->x, pointer->y);
    if (!met) return {};
    const Scene& scene = clip.scene();
    const int x = static_cast<int>(std::lround(met->x)), y = static_cast<int>(std::lround(met->y));
    const PixelValues values = values_at(field, moment.held.pair, x, y);
    PlaceFacts place{{formatted("pixel %d, %d", x, y)}};
    std::vector<std::string>& lines = place.lines;
    if (moment.stored && !moment.stored->depth.empty())
        lines[0] += ", " + stored_in_words(moment.stored->depth, scene, x, y);
    if (values.valid) {
        const bool is_range = scene.depth.semantics == DepthSemantics::range;
        lines.push_back("z " + metres_in_words(values.z, scene) +
                        (is_range ? ", ray " + metres_in_words(values.depth, scene) : "") +
                        (values.height_mm != 0 ? formatted(", height %.2f mm", values.height_mm) : ""));
    }
    if (!met->drawn) {
        lines.insert(lines.end(), {values.valid ? "an edge:" : "no depth here:", "nothing to touch"});
        return place;
    }
    place.pixel = {x, y};
    if (!values.valid) return place;
    lines.push_back(formatted("stiffness %.2g N/mm of the hand", values.properties.stiffness / 1000));
    lines.push_back(formatted("friction %.2f, sliding %.2f", values.properties.static_friction,
                              values.properties.dynamic_friction));
    return place;
}

/// How well the machine keeps up.
std::vector<std::string> figure_words(const OpenedClip& clip, const ClipPicture& picture,
                                      const WatchedMoment& moment) {
    const WatchedFigures figures = clip.session().figures();
    const auto frame = static_cast<long long>(moment.held.pair.prev.number);
    return {clip.frames() > 0 ? formatted("frame %lld of %lld", frame, static_cast<long long>(clip.frames()))
                              : formatted("frame %lld", frame),
            formatted("%lld frames late, %lld left out", static_cast<long long>(figures.late_frames),
                      static_cast<long long>(figures.feed.dropped)),
            formatted("read %.1f ms, built %.1f ms", figures.feed.read_ms, figures.feed.build_ms),
            formatted("%lld of %lld ticks late", static_cast<long long>(figures.ticks.late),
                      static_cast<long long>(figures.ticks.ticks)),
            formatted("surface drawn at %dx%d", picture.drawn_width(), picture.drawn_height()) +
                (picture.drawn_step() == 1 ? std::string()
                                           : formatted(", every %d%s vertex", picture.drawn_step(),
                                                       picture.drawn_step() == 2 ? "nd" : "th")),
            "surface by the " + figures.feed.builder + " builder" +
                (clip.builder_why().empty() ? "" : ": " + clip.builder_why()),
            "picture by the " + std::string(picture.graphics().painter()) + " painter on " +
                (picture.graphics().gpu().empty() ? "the CPU" : picture.graphics().gpu())};
}

/// Whether a finger has to leave a surface that was not there before it.
bool is_inside(const WatchedTick& felt) {
    return std::any_of(felt.fingers.begin(), felt.fingers.end(), [](const WatchedFinger& finger) {
        return (finger.force.reasons & guard_waiting) != 0;
    });
}

}  // namespace

PanelFacts panel_facts(const OpenedClip& clip, const ClipPicture& picture, const WatchedMoment& moment,
                       const HeightField& field, const ViewCamera& camera) {
    const PlaybackState state = clip.session().playback();
    PanelFacts facts;
    facts.clip = clip.name();
    facts.frame = moment.held.pair.prev.number;
    facts.seconds = static_cast<double>(state.moment.time_ns) * 1e-9;
    if (clip.frames() > 0) facts.seconds = std::min(facts.seconds, clip.seconds());
    facts.clip_seconds = clip.seconds();
    facts.last_seconds = clip.frames() > 0
                             ? static_cast<double>(clip.scene().rate.time_ns(clip.frames() - 1)) * 1e-9
                             : facts.clip_seconds;
    facts.cuts = clip.cuts();
    facts.playing = state.playing;
    facts.looping = state.loops;
    facts.at_end = state.at_end;
    facts.speed = static_cast<double>(state.rate) / 1000;
    facts.overlay = name_of(picture.overlay());
    facts.scale = picture.scale();
    facts.force_on = clip.force_is_on();
    if (const PersistentDevice* const hand = clip.hand())
        facts.hand = HandFacts{
            hand->name(), hand_state(*hand, *clip.control(), is_inside(moment.felt)), hand->age_s(),
            clip.scene().metres_per_unit / clip.control()->mapping().workspace.metres_per_scene_unit,
            hand->capabilities().buttons};
    facts.limit_newtons = clip.sizes().limit_newtons;
    facts.pressed_mm = clip.fingers().depth_m() * 1000;
    const auto fingers =
        std::min(moment.felt.fingers.size(),
                 static_cast<std::size_t>(clip.hand() ? clip.shown() : clip.fingers().present()));
    for (std::size_t k = 0; k < fingers; ++k)
        facts.forces.push_back(glm::length(moment.felt.fingers[k].force.force));
    facts.place = place_facts(clip, moment, field, camera);
    facts.settings = {clip.settings().values(), clip.in_effect(), clip.filters()};
    facts.settings.has_device = clip.hand() != nullptr;
    facts.figures = figure_words(clip, picture, moment);
    const WatchedFigures figures = clip.session().figures();
    facts.late_ticks = figures.ticks.late;
    facts.dropped_frames = figures.feed.dropped;
    return facts;
}

}  // namespace touchable
