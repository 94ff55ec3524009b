#include "engine/picture/disparity_tracks.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

extern "C" {
#include <libavutil/intreadwrite.h>

#include "engine/base/try.hpp"
}

namespace touchable {
namespace {

constexpr std::string_view disparity = "dish", hevc = "hvc1";
/// Of boxes in boxes, down to a table of samples; and of tracks of disparity, of which there is one.
constexpr int deepest = 6;
constexpr std::size_t most_tracks = 16;

class TrackSearch {
public:
    explicit TrackSearch(ByteSource& bytes) : bytes_(bytes) {}
    Result<void> boxes(std::uint64_t at, std::uint64_t end);
    DisparityTracks take() { return std::move(found_); }

private:
    Result<void> box(std::string_view type, std::uint64_t content, std::uint64_t end);
    /// The bytes from there on; zeros beyond the end.
    template <std::size_t count>
    Result<std::array<std::uint8_t, count>> at(std::uint64_t place, std::uint64_t end) {
        std::array<std::uint8_t, count> read{};
        const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(count, end - place));
        TRY(bytes_.read(place, reinterpret_cast<char*>(read.data()), some));
        return read;
    }

    ByteSource& bytes_;
    DisparityTracks found_;
    int track_ = 0, depth_ = 0;
};

Result<void> TrackSearch::boxes(std::uint64_t place, std::uint64_t end) {
    while (place + 8 <= end) {
        TRY_ASSIGN(const auto head, at<16>(place, end));
        const std::uint64_t stated = AV_RB32(head.data()), before = stated == 1 ? 16 : 8;
        const std::uint64_t size = stated == 0   ? end - place
                                   : stated == 1 ? AV_RB64(head.data() + 8)
                                                 : stated;
        if (size < before || size > end - place) return {};
        const std::string_view type(reinterpret_cast<const char*>(head.data()) + 4, 4);
        if (auto done = box(type, place + before, place + size); !done) return done;
        place += size;
    }
    return {};
}

Result<void> TrackSearch::box(std::string_view type, std::uint64_t content, std::uint64_t end) {
    for (const char* each : {"moov", "trak", "mdia", "minf", "stbl"})
        if (type == each && depth_ < deepest) {
            ++depth_;
            auto searched = boxes(content, end);
            --depth_;
            return searched;
        }
    if (type == "tkhd" && content < end) {
        TRY_ASSIGN(const auto head, at<24>(content, end));
        track_ = static_cast<int>(AV_RB32(head.data() + (head[0] == 1 ? 20 : 12)));  // behind its times
    }
    constexpr std::uint64_t entry = 8;  // behind version and count
    if (type == "stsd" && content + entry + 8 <= end) {
        TRY_ASSIGN(const auto head, at<16>(content, end));
        const std::string_view name(reinterpret_cast<const char*>(head.data()) + entry + 4, 4);
        if (name != disparity || found_.ids.size() == most_tracks) return {};
        found_.ids.push_back(track_);
        found_.names_at.push_back(content + entry + 4);
    }
    return {};
}

class ShownAsHevc final : public ByteSource {
public:
    ShownAsHevc(std::unique_ptr<ByteSource> bytes, std::vector<std::uint64_t> names_at)
        : bytes_(std::move(bytes)), names_at_(std::move(names_at)) {}
    std::uint64_t size() const override { return bytes_->size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (auto done = bytes_->read(at, to, count); !done) return done;
        for (const std::uint64_t name : names_at_)
            for (std::size_t k = 0; k < hevc.size(); ++k)
                if (name + k >= at && name + k < at + count) to[name + k - at] = hevc[k];
        return {};
    }

private:
    std::unique_ptr<ByteSource> bytes_;
    std::vector<std::uint64_t> names_at_;
};

}  // namespace

Result<DisparityTracks> find_disparity_tracks(ByteSource& bytes, std::uint64_t end) {
    TrackSearch search(bytes);
    TRY(search.boxes(0, end));
    return search.take();
}

std::unique_ptr<ByteSource> shown_as_hevc(std::unique_ptr<ByteSource> bytes,
                                          std::vector<std::uint64_t> names_at) {
    return std::make_unique<ShownAsHevc>(std::move(bytes), std::move(names_at));
}

}  // namespace touchable
