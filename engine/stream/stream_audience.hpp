#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/clip/stream_figures.hpp"

namespace touchable {

/// What begins the one line that a listener by TCP gets in place of a stream; the reason follows.
inline constexpr std::string_view stream_refusal = "touchable serve: ";

/// What one listener was given.
struct ListenerFigures {
    std::string name;                    ///< "tcp://192.168.0.5:41234"
    std::int64_t sent = 0, dropped = 0;  ///< framesets
    std::int64_t without_colour = 0;     ///< of those sent, because its link is narrow
    std::string end{};                   ///< why it is not there any more; empty: it had all of the stream
    std::optional<LinkFigures> link{};   ///< of its connection, where the transport counts (SRT)
};

/// Who listens to a stream, who did, and what they were given. From any thread.
class StreamAudience {
public:
    static constexpr int most_listeners = 64;

    /// `say` is told in one line who comes and goes, by one thread at a time.
    explicit StreamAudience(std::function<void(const std::string&)> say) : say_(std::move(say)) {}

    void came(const std::string& name);
    void went(ListenerFigures figures);
    /// That the link of one of them is too narrow for the colour.
    void goes_without_colour(const std::string& name);
    /// Something else that a person should know of the listeners.
    void remark(const std::string& line);

    int there() const { return there_; }
    bool has_room() const { return there_ < most_listeners; }
    /// The longest ago first, the last 256; and how many there were.
    std::vector<ListenerFigures> gone() const;
    std::int64_t all() const;

private:
    mutable std::mutex mutex_;
    std::function<void(const std::string&)> say_;  // guarded by mutex_, as is what follows
    std::vector<ListenerFigures> gone_;
    std::int64_t all_ = 0;
    std::atomic<int> there_{0};
};

}  // namespace touchable
