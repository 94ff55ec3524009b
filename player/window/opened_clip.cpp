#include "player/window/opened_clip.hpp"

#include <utility>

#include "player/session/recorded_facts.hpp"
#include "player/view/view_surface.hpp"

namespace touchable {

Result<std::unique_ptr<OpenedClip>> OpenedClip::open(const PlayOptions& options, const ClipChoice& clip,
                                                     WindowSound& sound) {
    std::unique_ptr<OpenedClip> made(new OpenedClip);
    made->device_ = std::make_shared<PointerDevice>(PointerFingers::most, glm::dvec3(0.0));
    SessionOptions session = options.session;
    session.clip = clip;
    session.live = session.watched = true;
    session.fingers = PointerFingers::most;
    session.held_device = made->device_;
    session.recorded = options.record.has_value();
    if (auto begun = made->begin(options, std::move(session), sound); !begun.ok()) return begun.error();
    return made;
}

Result<void> OpenedClip::begin(const PlayOptions& options, SessionOptions session, WindowSound& sound) {
    auto setup = setup_from_options(session);
    if (!setup.ok()) return setup.error();
    TouchSetup& s = **setup;
    name_ = s.clip.file.filename().empty() ? s.clip.file.parent_path().filename().string()
                                           : s.clip.file.filename().string();
    scene_ = s.scene;
    frames_ = s.feed->reader().frame_count().value_or(0);
    // No surface is before the clip's camera.
    device_->set_refuge(s.workspace.to_device({0, 0, 0}));
    fingers_.emplace(*device_, s.workspace);
    const auto first = s.feed->pair_at(PlaybackClock(s.scene.rate, s.settings.playback).at(0));
    if (!first.ok()) return first.error();
    const Subject subject = subject_of(HeightField(*scene_, *first));
    view_.emplace(*scene_, subject.middle);
    sizes_ = mark_sizes(*scene_, subject.middle);
    listener_.emplace(sound, scene_->width);
    std::vector<TouchSink*> sinks{&*listener_};
    if (options.record) {
        auto file = RecordingFile::create(*options.record, PointerFingers::most, options.existing);
        if (!file.ok()) return file.error();
        record_ = std::make_unique<Record>(std::move(*file));
        sinks.push_back(record_.get());
    }
    auto started = WatchedSession::start(std::move(*setup), std::move(sinks));
    if (!started.ok()) return started.error();
    session_ = std::move(*started);
    return {};
}

Result<void> OpenedClip::Record::take(const TouchTick& tick) {
    for (const GuardedForce& force : tick.forces) hash.add(force.force);
    return file->take(tick);
}

Result<void> OpenedClip::finish() {
    session_->stop();
    if (!record_) return {};
    const TouchSetup& setup = session_->setup();
    nlohmann::ordered_json facts = recorded_facts(setup);
    facts["force_hash"] = record_->hash.hex();
    return record_->file->finish(facts, setup.settings.playback);
}

}  // namespace touchable
