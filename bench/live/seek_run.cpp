// SPDX-License-Identifier: Apache-2.0
#include "bench/live/seek_run.hpp"

#include "bench/clocks.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {

Result<void> measure_seek(const LiveClip& clip, int seeks, LiveClips& clips, Figures& figures) {
    constexpr std::int64_t patience_ns = 30'000'000'000;
    const auto file = clips.file(clip);
    if (!file) return file.error();
    const auto source = clips.pictures(clip);
    if (!source) return source.error();
    const auto reader = open_clip(*file);
    if (!reader) return reader.error();
    (*reader)->leave_out_colour();
    std::vector<double> ms;
    SplitMix64 random(1);
    const std::int64_t start = monotonic_ns();
    // If a seek reads everything before its target, a few seeks suffice.
    while (std::ssize(ms) < seeks && (ms.size() < 3 || monotonic_ns() - start < patience_ns)) {
        if (stop_requested()) return interrupted_error();
        const auto frame = static_cast<std::int64_t>(random.unit() * clip.frames);
        const std::int64_t begin = monotonic_ns();
        if (auto found = (*reader)->seek(frame); !found) return found;
        const auto raw = (*reader)->next();
        ms.push_back(static_cast<double>(monotonic_ns() - begin) * 1e-6);
        if (!raw) return raw.error();
        if (!*raw || (*raw)->number != frame || !same_touch_planes(**raw, (*source)->of(frame)))
            return Error{ErrorKind::check, "after a seek to frame " + std::to_string(frame) +
                                               " another frame comes, or one with other planes"};
    }
    const auto quantile = [&ms](double share) {
        const auto rank = static_cast<std::size_t>(share * static_cast<double>(ms.size()));
        return sorted_element(ms, std::min(rank, ms.size() - 1));
    };
    figures.push_back({"seeks", static_cast<double>(ms.size()), ""});
    figures.push_back({"seek_ms_p50", quantile(0.5), "ms"});
    figures.push_back({"seek_ms_p99", quantile(0.99), "ms"});
    figures.push_back({"seek_ms_max", quantile(1), "ms"});
    return {};
}

}  // namespace touchable
