#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

namespace touchable {

/// What a listener on a narrow link goes without: its colour first, then framesets. Colour comes back once
/// the link has kept up without it for a while, which doubles each time that this was in vain. No clock is
/// read: moments are what it is given, ns.
class NarrowLink {
public:
    static constexpr std::int64_t colour_goes_after_ns = 150'000'000, framesets_go_after_ns = 300'000'000;
    static constexpr std::int64_t joins_within_ns = 1'000'000'000;
    static constexpr std::int64_t shortest_trial_ns = 5'000'000'000, longest_trial_ns = 80'000'000'000;

    /// The listener has everything that there is, or framesets were left out for it.
    void has_caught_up() { behind_since_ns_.reset(); }
    /// There is a frameset for it, and it cannot be given yet. True: from now on its colour is left out.
    /// `is_tried`: how much its link takes is being found out.
    bool is_behind(std::int64_t now_ns, bool is_tried = false) {
        if (!behind_since_ns_) behind_since_ns_ = now_ns;
        if (!first_behind_ns_) first_behind_ns_ = now_ns;
        // Whoever joins begins with a key of up to half a second ago.
        if (is_tried || now_ns - *first_behind_ns_ < joins_within_ns) return false;
        if (now_ns - *behind_since_ns_ < colour_goes_after_ns) return false;
        if (has_colour_) {
            const bool was_in_vain = colour_back_ns_ && now_ns - *colour_back_ns_ < longest_trial_ns;
            trial_ns_ = was_in_vain ? std::min(2 * trial_ns_, longest_trial_ns) : shortest_trial_ns;
        }
        next_trial_ns_ = now_ns + trial_ns_;
        return std::exchange(has_colour_, false);
    }
    /// It is so far behind that framesets are to be left out, too.
    bool is_far_behind(std::int64_t now_ns) const {
        return behind_since_ns_ && now_ns - *behind_since_ns_ > framesets_go_after_ns;
    }
    /// Whether the next frameset goes with its colour. Decoding of colour begins with a key.
    bool gives_colour(bool is_key, std::int64_t now_ns) {
        if (!has_colour_ && is_key && !behind_since_ns_ && now_ns >= next_trial_ns_) {
            has_colour_ = true;
            colour_back_ns_ = now_ns;
        }
        return has_colour_;
    }

private:
    std::optional<std::int64_t> first_behind_ns_, behind_since_ns_, colour_back_ns_;
    bool has_colour_ = true;
    std::int64_t trial_ns_ = shortest_trial_ns, next_trial_ns_ = 0;
};

}  // namespace touchable
