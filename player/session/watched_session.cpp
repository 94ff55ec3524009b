// SPDX-License-Identifier: Apache-2.0
#include "player/session/watched_session.hpp"

#include <array>
#include <cmath>
#include <new>

#include "device/hand.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

// A silent hand and a stalled program are handled by the same time limit.
static_assert(HandControl::away_ticks * tick_ns + static_cast<std::int64_t>(HapticDevice::oldest_s * 1e9) ==
              HapticLoop::longest_gap_ns);

/// A device held by the user, with the mapping, clutch and force enabling between it and the fingers.
class HeldPort final : public HapticPort {
public:
    /// All must outlive the port; the device is open. `log`: nullptr: no log.
    HeldPort(HapticDevice& device, HandControl& control, DeviceTickLog* log)
        : device_(device),
          control_(control),
          log_(log),
          has_motors_(device.capabilities().axes_driven > 0),
          places_(static_cast<std::size_t>(device.fingers())),
          newtons_(places_.size()) {}

    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override {
        tick_ = tick;
        if (!device_.read_positions(places_)) return false;
        std::ranges::copy(places_, goals.begin());
        const FieldProbe probe(field);
        control_.to_goals(goals, device_.buttons(), &probe);
        return true;
    }

    void come_back(std::int64_t alone_ms) override { control_.come_back(alone_ms); }

    bool write_forces(std::span<const glm::dvec3> newtons) override {
        const auto passed =
            static_cast<int>(std::min<std::int64_t>(tick_ - written_, HandControl::rise_ticks));
        const bool is_tick = tick_ > written_;  // the zeros at the end belong to no tick
        written_ = tick_;
        control_.to_device(newtons, passed, newtons_);
        for (std::size_t finger = 0; finger < newtons_.size(); ++finger)
            if (!has_place(finger) && std::isfinite(newtons_[finger].x)) newtons_[finger] = glm::dvec3(0.0);
        const bool works = device_.write_forces(newtons_);
        if (log_ && is_tick)
            log_->push({tick_, device_.buttons(), device_.age_s(), control_.exerts(), places_, newtons_});
        return works;
    }

    /// 1 if the device has no motors: the reported force is then the scene's.
    double share(std::size_t finger) const override {
        if (!has_motors_) return 1;
        return has_place(finger) ? control_.share(finger) : 0;
    }

private:
    /// A finger without a position has no force; its device would not exert one either.
    bool has_place(std::size_t finger) const { return std::isfinite(places_[finger].x); }

    HapticDevice& device_;
    HandControl& control_;
    DeviceTickLog* log_;
    const bool has_motors_;
    std::vector<glm::dvec3> places_, newtons_;
    std::int64_t tick_ = -1, written_ = -1;
};

/// The result of `work`, or of its exception.
Result<void> caught(auto&& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return no_memory_for("the session's ticks");
    } catch (const std::exception& fault) {
        return internal_error(std::string("while the session ran: ") + fault.what());
    }
}

HapticDevice* device_of(const TouchSetup& setup) {
    return setup.options.held_device ? setup.options.held_device.get() : setup.device.get();
}

}  // namespace

/// Hands the newest tick from the session's thread to the watcher's.
class WatchedSession::Ticks final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override {
        const std::lock_guard lock(mutex_);
        figures_.late += tick.tick > newest_.tick + 1;
        ++figures_.ticks;
        figures_.solve_us = tick.solve_us;
        ++late_[std::min(static_cast<std::size_t>(std::max(tick.late_us, 0.0) / late_step_us),
                         late_.size() - 1)];
        newest_.tick = tick.tick;
        newest_.fingers.resize(tick.contacts.size());
        for (std::size_t k = 0; k < tick.contacts.size(); ++k)
            newest_.fingers[k] = {
                tick.goals[k], tick.contacts[k], {tick.sent(k), tick.forces[k].reasons, {}}};
        return {};
    }
    void copy_newest(WatchedTick& to) const {
        const std::lock_guard lock(mutex_);
        to = newest_;
    }
    WatchedFigures::Ticks figures() const {
        const std::lock_guard lock(mutex_);
        WatchedFigures::Ticks figures = figures_;
        std::int64_t later = 0;
        std::size_t step = late_.size();
        while (step > 0 && 100 * (later + late_[step - 1]) <= figures.ticks) later += late_[--step];
        figures.late_us_p99 = late_step_us * static_cast<double>(step);
        return figures;
    }

private:
    mutable std::mutex mutex_;
    WatchedTick newest_;
    WatchedFigures::Ticks figures_;
    static constexpr double late_step_us = 10;
    std::array<std::int64_t, 100> late_{};  // ticks by how late they were
};

Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup) {
    if (HapticDevice* device = device_of(setup)) TRY(device->open());
    if (setup.options.control)
        return std::make_unique<HeldPort>(*setup.options.held_device, *setup.options.control,
                                          setup.device_log.get());
    if (setup.options.held_device) return make_port(*setup.options.held_device, setup.workspace);
    return setup.device ? make_port(*setup.hand, *setup.device, setup.workspace) : make_port(*setup.hand);
}

void explain_failure(const TouchSetup& setup, LiveFacts& facts) {
    const HapticDevice* device = device_of(setup);
    if (!facts.loop.port_failed || !device) return;
    if (auto healthy = device->health(); !healthy) facts.failure = healthy.error();
}

Result<std::unique_ptr<WatchedSession>> WatchedSession::start(std::unique_ptr<TouchSetup> setup,
                                                              std::vector<TouchSink*> sinks, bool stepped) {
    for (const PlaybackCommand& command : setup->options.playback)
        if (command.tick > 0)
            return usage_error("playback '" + in_words({command}) +
                               "': in a window, commands are given as the clip plays; must take "
                               "effect at 0 s");
    std::unique_ptr<WatchedSession> session(new WatchedSession(std::move(setup), std::move(sinks)));
    TouchSetup& s = *session->setup_;
    TRY_ASSIGN(session->port_, open_port(s));
    session->live_.emplace(*s.feed, *session->port_, *s.solver, s.options, session->log_);
    session->running_.store(true, std::memory_order_release);
    if (stepped) {
        s.feed->work_ahead();
        return session;
    }
    auto begun =
        start_thread(session->thread_, "session", "of the session", [it = session.get()] { it->run(); });
    if (begun) return session;
    session->close_devices();
    return begun.error();
}

WatchedSession::WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks)
    : setup_(std::move(setup)),
      log_(std::make_shared<PlaybackLog>(setup_->options.playback, most_commands)),
      ticks_(std::make_unique<Ticks>()),
      sinks_(std::move(sinks)) {
    if (const auto frames = setup_->feed->reader().frame_count())
        clip_end_ns_ = setup_->scene.rate.time_ns(*frames);
    sinks_.push_back(ticks_.get());
}

WatchedSession::~WatchedSession() {
    stop();
}

void WatchedSession::run() {
    ran_ = caught([this] { return live_->run(sinks_); });
    note_end();
}

void WatchedSession::run_tick() {
    if (!running()) return;
    ran_ = caught([this] { return live_->run_tick(sinks_); });
    if (!ran_) note_end();
}

void WatchedSession::note_end() {
    facts_ = live_->facts();
    explain_failure(*setup_, facts_);
    running_.store(false, std::memory_order_release);
}

void WatchedSession::stop() {
    if (!live_ || std::exchange(is_stopped_, true)) return;
    live_->stop();
    if (thread_.joinable()) thread_.join();
    if (running()) note_end();  // stepped
    close_devices();
    setup_->options.playback = log_->commands();
}

void WatchedSession::close_devices() {
    if (setup_->device) setup_->device->close();
    if (setup_->options.held_device) setup_->options.held_device->close();
}

Result<void> WatchedSession::ask(PlaybackVerb verb, std::int64_t first, std::int64_t second) {
    const PlaybackCommand command{0, verb, first, second};
    if (const auto fault = fault_after(0, command)) return usage_error("playback: " + *fault);
    if (setup_->feed->reader().is_live())
        return usage_error("playback: a camera's time only goes on; a clip would take commands");
    const bool goes_there = verb == PlaybackVerb::seek || verb == PlaybackVerb::loop;
    if (goes_there && clip_end_ns_ && first >= *clip_end_ns_)
        return usage_error("playback: the clip ends at " +
                           std::to_string(static_cast<double>(*clip_end_ns_) * 1e-9) +
                           " s; must be before that");
    if (!running()) return usage_error("playback: the session has ended; it takes no more commands");
    return log_->ask(verb, first, second);
}

const WatchedMoment* WatchedSession::look() {
    const SurfaceTimeline::HeldPair* held = setup_->feed->timeline().look();
    if (!held) return nullptr;
    seen_.held = *held;
    seen_.stored = setup_->feed->stored_planes(held->pair.epoch, held->pair.nearer().number);
    ticks_->copy_newest(seen_.felt);
    return &seen_;
}

PlaybackState WatchedSession::playback() const {
    return until_end(live_->playback(), setup_->scene.rate, clip_end_ns_.value_or(live_->clip_end_ns()));
}

std::string WatchedSession::silence(const WatchedMoment& moment) const {
    const FramePair& pair = moment.held.pair;
    return silence_in_words(moment.felt.tick * tick_ns - std::max(pair.prev.time_ns, pair.next.time_ns),
                            setup_->options.guard.stale_after_ns, setup_->feed->reader());
}

WatchedFigures WatchedSession::figures() const {
    return {setup_->feed->figures(), ticks_->figures(), live_->late_frames()};
}

}  // namespace touchable
