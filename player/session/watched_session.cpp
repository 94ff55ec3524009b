#include "player/session/watched_session.hpp"

#include <algorithm>

#include <exception>
#include <new>
#include <utility>

#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "player/run/memory.hpp"
#include "player/session/live_port.hpp"
#include "player/session/playback_script.hpp"

namespace touchable {

Result<std::unique_ptr<WatchedSession>> WatchedSession::start(std::unique_ptr<TouchSetup> setup,
                                                              std::vector<TouchSink*> sinks) {
    for (const PlaybackCommand& command : setup->settings.playback)
        if (command.tick > 0)
            return usage_error("playback '" + in_words({command}) +
                               "': where somebody watches, commands are given as the clip plays; right would "
                               "be what takes effect at 0 s");
    std::unique_ptr<WatchedSession> session(new WatchedSession(std::move(setup), std::move(sinks)));
    TRY_ASSIGN(auto port, open_port(*session->setup_));
    session->port_ = std::move(port);
    TouchSetup& s = *session->setup_;
    session->live_.emplace(s.scene, *s.feed, *session->port_, *s.solver, s.settings, session->log_);
    session->running_.store(true, std::memory_order_release);
    auto begun =
        start_thread(session->thread_, "session", "of the session", [it = session.get()] { it->run(); });
    if (begun.ok()) return session;
    session->close_devices();
    return begun.error();
}

WatchedSession::WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks)
    : setup_(std::move(setup)),
      log_(std::make_shared<PlaybackLog>(setup_->settings.playback, most_commands)),
      sinks_(std::move(sinks)) {
    if (const auto frames = setup_->feed->reader().frame_count())
        clip_end_ns_ = setup_->scene.rate.time_ns(*frames);
    sinks_.push_back(&ticks_);
}

WatchedSession::~WatchedSession() {
    stop();
}

/// Nothing thrown leaves the thread.
void WatchedSession::run() {
    try {
        ran_ = live_->run(sinks_);
    } catch (const std::bad_alloc&) {
        ran_ = too_large("the session's ticks");
    } catch (const std::exception& fault) {
        ran_ = Error{ErrorKind::internal, std::string("while the session ran: ") + fault.what()};
    }
    facts_ = live_->facts();
    explain_failure(*setup_, facts_);
    running_.store(false, std::memory_order_release);
}

void WatchedSession::stop() {
    if (!thread_.joinable()) return;
    live_->stop();
    thread_.join();
    close_devices();
    setup_->settings.playback = log_->commands();
}

void WatchedSession::close_devices() {
    if (setup_->device) setup_->device->close();
    if (setup_->held_device) setup_->held_device->close();
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
                           " s; right would be a moment before");
    if (!running()) return usage_error("playback: the session has ended; it takes no more commands");
    return log_->ask(verb, first, second);
}

const WatchedMoment* WatchedSession::look() {
    const HeldPair* held = setup_->feed->timeline().look();
    if (!held) return nullptr;
    const auto nearer = [](const FramePair& pair) { return pair.blend < 0.5 ? pair.prev : pair.next; };
    seen_.held = *held;
    seen_.stored = setup_->feed->stored_planes().find(held->pair.epoch, nearer(held->pair).number);
    ticks_.copy_newest(seen_.felt);
    return &seen_;
}

PlaybackState WatchedSession::playback() const {
    PlaybackState now = live_->playback();
    const std::int64_t end_ns = clip_end_ns_.value_or(live_->clip_end_ns());
    const FrameRate& rate = setup_->scene.rate;
    if (end_ns <= 0 || now.loops) return now;
    // The clock goes on; the clip stands still.
    const std::int64_t last_ns = rate.time_ns(rate.frame_at(end_ns) - 1);
    now.at_end = now.moment.time_ns >= last_ns;
    now.moment.time_ns = std::min(now.moment.time_ns, last_ns);
    return now;
}

WatchedFigures WatchedSession::figures() const {
    return {setup_->feed->figures(), ticks_.figures(), live_->late_frames()};
}

std::optional<Error> WatchedSession::failure() const {
    return ran_.ok() ? facts_.failure : std::optional(ran_.error());
}

}  // namespace touchable
