#include "engine/formats/bag_recording.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/ros_messages.hpp"
#include "engine/formats/ros_picture.hpp"

namespace touchable {
namespace {

struct Stamped {
    std::int64_t taken_ns;
    BagMessage message;
};

/// Of all messages, read in the order in which they lie in the file, so that each chunk is unpacked once.
/// Those in chunks that were given up are left out.
Result<std::vector<Stamped>> with_stamps(BagFile& bag, std::vector<BagMessage> messages) {
    std::sort(messages.begin(), messages.end(), [](const BagMessage& a, const BagMessage& b) {
        return std::tie(a.chunk, a.offset) < std::tie(b.chunk, b.offset);
    });
    std::vector<Stamped> stamped;
    for (const BagMessage& message : messages) {
        if (stop_requested())
            return Error{ErrorKind::interrupted, "interrupted while " + bag.name() + " was looked through"};
        const auto begin = bag.read(message, ros_stamp_bytes);
        if (!begin && bag.is_given_up(message)) continue;
        if (!begin) return begin.error();
        stamped.push_back({ros_stamp(*begin).value_or(0), message});
    }
    return stamped;
}

double seconds(std::int64_t nanoseconds) {
    return 1e-9 * static_cast<double>(nanoseconds);
}

/// Whether both have stamps, by one clock.
bool tell_times(const std::vector<Stamped>& depth, const std::vector<Stamped>& colour) {
    const auto ends = [](const std::vector<Stamped>& all) {
        const auto [first, last] =
            std::minmax_element(all.begin(), all.end(),
                                [](const Stamped& a, const Stamped& b) { return a.taken_ns < b.taken_ns; });
        return std::pair(first->taken_ns, last->taken_ns);
    };
    const auto [first, last] = ends(depth);
    if (first <= 0 || (depth.size() > 1 && first == last)) return false;
    if (colour.empty()) return true;
    constexpr std::int64_t second = 1'000'000'000;
    const auto [begin, end] = ends(colour);
    return begin > 0 && begin <= last + second && first <= end + second;
}

}  // namespace

Result<BagRecording> BagRecording::open(const SourceFile& file) {
    BagRecording recording;
    TRY_ASSIGN(auto bag, BagFile::open(file));
    recording.bag_ = std::move(bag);
    TRY_ASSIGN(auto streams, choose_bag_streams(*recording.bag_));
    recording.streams_ = std::move(streams);
    TRY(recording.put_in_order());
    return recording;
}

Result<void> BagRecording::put_in_order() {
    const std::size_t depths = streams_.depth.messages.size();
    std::vector<BagMessage> all = streams_.depth.messages;
    if (has_colour())
        all.insert(all.end(), streams_.colour->messages.begin(), streams_.colour->messages.end());
    TRY_ASSIGN(auto stamped, with_stamps(*bag_, std::move(all)));
    std::vector<std::uint32_t> depth_ids;
    for (const BagMessage& message : streams_.depth.messages) depth_ids.push_back(message.connection);
    std::sort(depth_ids.begin(), depth_ids.end());
    std::vector<Stamped> depth, colour;
    depth.reserve(depths);
    for (const Stamped& each : stamped)
        (std::binary_search(depth_ids.begin(), depth_ids.end(), each.message.connection) ? depth : colour)
            .push_back(each);
    if (depth.empty()) return input_error(bag_->name() + ": " + bag_->left_out());
    if (colour.empty()) streams_.colour.reset();
    const bool by_stamp = tell_times(depth, colour);
    const auto order = [&](std::vector<Stamped>& pictures, std::vector<BagMessage>& messages) {
        const auto time = [&](const Stamped& each) {
            return by_stamp ? each.taken_ns : each.message.time_ns;
        };
        std::stable_sort(pictures.begin(), pictures.end(),
                         [&](const Stamped& a, const Stamped& b) { return time(a) < time(b); });
        std::vector<double> times;
        messages.clear();
        for (const Stamped& each : pictures) {
            times.push_back(seconds(time(each)));
            messages.push_back(each.message);
        }
        return times;
    };
    times_ = order(depth, streams_.depth.messages);
    if (!has_colour()) return {};
    const std::vector<double> colour_times = order(colour, streams_.colour->messages);
    for (const double time : times_) colours_.push_back(nearest_key(colour_times, time));
    return {};
}

std::string BagRecording::where(const BagPictures& pictures, std::int64_t frame) const {
    return bag_->name() + ": " + printable(pictures.topic) + ", frame " + std::to_string(frame);
}

Result<StoredImage> BagRecording::picture(const BagPictures& pictures, const BagMessage& message,
                                          std::int64_t frame) {
    TRY_ASSIGN(const auto bytes, bag_->read(message));
    const std::string at = where(pictures, frame);
    if (pictures.is_compressed) {
        const auto image = parse_ros_compressed_image(bytes);
        return image ? ros_picture(*image, at) : input_error(at + ": is damaged: is cut");
    }
    const auto image = parse_ros_image(bytes);
    return image ? ros_picture(*image, at) : input_error(at + ": is damaged: is cut");
}

Result<StoredImage> BagRecording::depth(std::int64_t frame) {
    return picture(streams_.depth, streams_.depth.messages[static_cast<std::size_t>(frame)], frame);
}

Result<StoredImage> BagRecording::colour(std::int64_t frame) {
    const std::size_t place = colours_[static_cast<std::size_t>(frame)];
    return picture(*streams_.colour, streams_.colour->messages[place], frame);
}

}  // namespace touchable
