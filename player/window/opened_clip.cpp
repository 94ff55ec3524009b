#include "player/window/opened_clip.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "player/session/filter_words.hpp"
#include "player/session/recorded_facts.hpp"
#include "player/view/view_surface.hpp"

namespace touchable {
namespace {

/// A device that stays open from one session to the next, so that its fingers stay where they are.
class StaysOpen final : public HapticDevice {
public:
    explicit StaysOpen(std::shared_ptr<PointerDevice> device) : device_(std::move(device)) {}
    ~StaysOpen() override { device_->close(); }
    std::string name() const override { return device_->name(); }
    DeviceLimits limits() const override { return device_->limits(); }
    int fingers() const override { return device_->fingers(); }
    Result<void> open() override {
        if (std::exchange(is_open_, true) && device_->health().ok()) return {};
        return device_->open();
    }
    /// No force is left of the session that has ended.
    void close() override {
        if (is_open_) device_->write_forces(std::vector<glm::dvec3>(static_cast<std::size_t>(fingers())));
    }
    bool read_positions(std::span<glm::dvec3> device_metres) override {
        return device_->read_positions(device_metres);
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_->write_forces(newtons); }
    Result<void> health() const override { return device_->health(); }

private:
    std::shared_ptr<PointerDevice> device_;
    bool is_open_ = false;
};

}  // namespace

OpenedClip::OpenedClip(const PlayOptions& options, const ClipChoice& clip, WindowSound& sound)
    : options_(options),
      clip_(clip),
      sound_(sound),
      device_(std::make_shared<PointerDevice>(PointerFingers::most, glm::dvec3(0.0))),
      held_(std::make_shared<StaysOpen>(device_)) {}

Result<std::unique_ptr<OpenedClip>> OpenedClip::open(const PlayOptions& options, const ClipChoice& clip,
                                                     const FeltSettings& felt, WindowSound& sound) {
    std::unique_ptr<OpenedClip> made(new OpenedClip(options, clip, sound));
    if (auto begun = made->begin(felt); !begun.ok()) return begun.error();
    return made;
}

SessionOptions OpenedClip::session_options(const FeltSettings& felt) const {
    SessionOptions session = options_.session;
    session.clip = clip_;
    session.live = session.watched = true;
    session.fingers = PointerFingers::most;
    session.held_device = held_;
    session.recorded = options_.record.has_value();
    return with_felt(std::move(session), felt);
}

/// What a setup says of the clip by these settings. No session is running.
void OpenedClip::take_over(const TouchSetup& setup, const FeltSettings& felt) {
    scene_ = setup.scene;
    felt_ = felt;
    in_effect_ = felt_in(setup);
    filters_ = filters_in_words(setup.scene, setup.filters);
    if (setup.filters) clip_.measured = MeasuredFrames{setup.filters->measured, setup.filters->damage};
    // No surface is before the clip's camera.
    device_->set_refuge(setup.workspace.to_device({0, 0, 0}));
}

Result<void> OpenedClip::begin(const FeltSettings& felt) {
    auto setup = setup_from_options(session_options(felt));
    if (!setup.ok()) return setup.error();
    TouchSetup& s = **setup;
    name_ = s.clip.file.filename().empty() ? s.clip.file.parent_path().filename().string()
                                           : s.clip.file.filename().string();
    frames_ = s.feed->reader().frame_count().value_or(0);
    take_over(s, felt);
    fingers_.emplace(*device_, s.workspace);
    const auto first = s.feed->pair_at(PlaybackClock(s.scene.rate, s.settings.playback).at(0));
    if (!first.ok()) return first.error();
    const Subject subject = subject_of(HeightField(*scene_, *first));
    view_.emplace(*scene_, subject.middle);
    sizes_ = mark_sizes(*scene_, subject.middle);
    listener_.emplace(sound_, scene_->width);
    std::vector<TouchSink*> sinks{&*listener_};
    if (options_.record) {
        auto file = RecordingFile::create(*options_.record, PointerFingers::most, options_.existing);
        if (!file.ok()) return file.error();
        record_ = std::make_unique<Record>(std::move(*file));
        sinks.push_back(record_.get());
    }
    auto started = WatchedSession::start(std::move(*setup), std::move(sinks));
    if (!started.ok()) return started.error();
    session_ = std::move(*started);
    return {};
}

/// Stops the clip where it is, and gives what leads another session to that moment, to go on from there.
std::vector<PlaybackCommand> OpenedClip::stand_still() {
    using namespace std::chrono_literals;
    PlaybackState was = session_->playback();
    const bool played = was.playing;
    if (played && session_->ask(PlaybackVerb::pause).ok())
        for (int k = 0; k < 50 && was.playing && session_->running(); ++k) {
            std::this_thread::sleep_for(1ms);
            was = session_->playback();
        }
    const FrameRate& rate = scene_->rate;
    const std::int64_t last_ns = frames_ > 0 ? rate.time_ns(frames_) - 1 : latest_moment_ns;
    std::vector<PlaybackCommand> again{{0, PlaybackVerb::rate, was.rate, 0},
                                       {0, PlaybackVerb::seek, std::min(was.moment.time_ns, last_ns), 0}};
    if (was.loops) again.push_back({0, PlaybackVerb::loop, was.loop_begin_ns, was.loop_end_ns});
    if (!played) again.push_back({0, PlaybackVerb::pause, 0, 0});
    return again;
}

void OpenedClip::begin_sound() {
    sound_.open_clip(session_->setup().clip.file);
    listener_->begin(session_->clock(), frames_ > 0 ? scene_->rate.time_ns(frames_) : latest_moment_ns);
}

Result<void> OpenedClip::change(const FeltSettings& felt) {
    if (felt == felt_) return {};
    SessionOptions session = session_options(felt);
    session.playback = stand_still();
    // A finger that was inside stays there: how the surface is felt is new, and the ramp is for that.
    session.start_buried = true;
    auto setup = setup_from_options(session);
    if (!setup.ok()) {
        if (session.playback.back().verb != PlaybackVerb::pause) (void)session_->ask(PlaybackVerb::play);
        return setup.error();
    }
    session_->stop();
    const FeltSettings before = felt_;
    take_over(**setup, felt);
    fingers_->set_workspace((*setup)->workspace);
    trails_ = FingerTrails();
    listener_.emplace(sound_, scene_->width);
    auto started = WatchedSession::start(std::move(*setup), {&*listener_});
    if (!started.ok()) {
        felt_ = before;
        return started.error();
    }
    session_ = std::move(*started);
    begin_sound();
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
