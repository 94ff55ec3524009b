#include "engine/formats/jpeg_segments.hpp"

#include <algorithm>

namespace touchable {
namespace {

using namespace std::string_view_literals;

constexpr char app1 = '\xe1', start_of_scan = '\xda', end_of_image = '\xd9';

/// Goes from segment to segment; coded data, which has none but restarts in it, is passed over.
class SegmentReader {
public:
    explicit SegmentReader(std::string_view jpeg) : all_(jpeg) {
        if (all_.starts_with("\xff\xd8"sv)) at_ = 2;
    }
    /// The marker of the next segment, and `content`; nothing where it is cut.
    std::optional<char> next() {
        if (at_ == 0) return std::nullopt;
        if (in_scan_) skip_coded();
        while (at_ + 1 < all_.size() && all_[at_] == '\xff' && all_[at_ + 1] == '\xff') ++at_;  // fill
        if (at_ + 2 > all_.size() || all_[at_] != '\xff') return std::nullopt;
        const char marker = all_[at_ + 1];
        at_ += 2;
        content = {};
        if (marker == end_of_image) return marker;
        if (at_ + 2 > all_.size()) return std::nullopt;
        const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(all_[at_ + k]); };
        std::size_t length = std::size_t{byte(0)} << 8 | byte(1);  // of itself and the content
        if (marker == start_of_scan) length = std::min(length, all_.size() - at_);  // its picture is cut
        if (length < 2 || length > all_.size() - at_) return std::nullopt;
        content = all_.substr(at_ + 2, length - 2);
        at_ += length;
        in_scan_ = marker == start_of_scan;
        return marker;
    }
    std::size_t position() const { return at_; }

    std::string_view content;

private:
    void skip_coded() {
        in_scan_ = false;
        for (at_ = all_.find('\xff', at_); at_ < all_.size(); at_ = all_.find('\xff', at_ + 1)) {
            const auto marker = static_cast<unsigned char>(at_ + 1 < all_.size() ? all_[at_ + 1] : 0);
            if (marker != 0 && marker != 0xff && (marker < 0xd0 || marker > 0xd7)) return;
        }
        at_ = all_.size();
    }

    std::string_view all_;
    std::size_t at_ = 0;
    bool in_scan_ = false;
};

}  // namespace

std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg) {
    std::vector<std::string_view> segments;
    SegmentReader reader(jpeg);
    while (const auto marker = reader.next()) {
        if (*marker == start_of_scan) return segments;
        if (*marker == app1) segments.push_back(reader.content);
    }
    return std::nullopt;
}

std::optional<std::size_t> jpeg_length(std::string_view file) {
    SegmentReader reader(file);
    while (const auto marker = reader.next())
        if (*marker == end_of_image) return reader.position();
    return std::nullopt;
}

}  // namespace touchable
