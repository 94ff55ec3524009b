#include <algorithm>
#include <string>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/scene_stream.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::uint64_t most_sample_bytes = 64 << 10;

/// A descriptor of MPEG-4 Systems: a tag, a length, and what is in it.
struct Descriptor {
    std::uint8_t tag = 0;
    BytesView content;
};

Result<std::vector<Descriptor>> descriptors_in(BytesView bytes) {
    std::vector<Descriptor> all;
    std::size_t at = 0;
    while (at < bytes.size()) {
        const std::uint8_t tag = bytes[at++];
        std::uint64_t size = 0;
        int length_bytes = 0;
        bool goes_on = true;
        while (goes_on && length_bytes < 4 && at < bytes.size()) {
            goes_on = (bytes[at] & 128) != 0;
            size = size << 7 | (bytes[at] & 127);
            ++at;
            ++length_bytes;
        }
        if (goes_on || size > bytes.size() - at)
            return input_error("a descriptor of " + std::to_string(size) + " bytes: must be " +
                               std::to_string(bytes.size() - at) + " at most");
        all.push_back({tag, bytes.subspan(at, size)});
        at += size;
    }
    return all;
}

const Descriptor* with_tag(std::span<const Descriptor> all, std::uint8_t tag) {
    const auto found =
        std::find_if(all.begin(), all.end(), [tag](const Descriptor& each) { return each.tag == tag; });
    return found == all.end() ? nullptr : &*found;
}

struct Track {
    std::uint32_t id = 0;
    std::string handler;
    BytesView content;
};

std::vector<Track> tracks_of(std::span<const Box> boxes) {
    std::vector<Track> tracks;
    for (const Box& box : boxes) {
        if (box.type != "trak") continue;
        const BytesView head = content_at(box.content, {"tkhd"}),
                        handler = content_at(box.content, {"mdia", "hdlr"});
        if (head.size() < 24 || handler.size() < 12) continue;
        tracks.push_back({static_cast<std::uint32_t>(number_at(head, head[0] == 1 ? 20 : 12, 4)),
                          std::string(reinterpret_cast<const char*>(handler.data()) + 8, 4), box.content});
    }
    return tracks;
}

Result<FirstSample> first_sample_of(const Track& track) {
    const auto of = [&](std::string_view table) {
        return content_at(track.content, {"mdia", "minf", "stbl", table});
    };
    const BytesView sizes = of("stsz"), places = of("stco"), far_places = of("co64");
    const std::uint64_t common = number_at(sizes, 4, 4);
    const std::uint64_t size = common > 0 ? common : number_at(sizes, 12, 4);
    const bool is_near = places.size() >= 12;
    if (sizes.size() < 12 || size == 0 || (!is_near && far_places.size() < 16))
        return input_error("track " + std::to_string(track.id) + " (" + in_quotes(track.handler) +
                           ") has no sample");
    return FirstSample{is_near ? number_at(places, 8, 4) : number_at(far_places, 8, 8), size,
                       number_at(sizes, 8, 4)};
}

/// Its first, which says all.
Result<Bytes> first_sample(const Track& track, const ReadBytes& read) {
    TRY_ASSIGN(const auto sample, first_sample_of(track));
    if (sample.bytes > most_sample_bytes)
        return input_error("track " + std::to_string(track.id) + " has a sample of " +
                           std::to_string(sample.bytes) + " bytes: must be 1 to 65536");
    return read(sample.at, sample.bytes);
}

Result<BifsConfig> config_of(const Track& track) {
    constexpr std::size_t kinds_head = 8, entry_head = 8;
    const BytesView kinds = content_at(track.content, {"mdia", "minf", "stbl", "stsd"});
    const BytesView entry = content_at(kinds.subspan(std::min(kinds_head, kinds.size())), {"mp4s"});
    const BytesView esds = content_at(entry.subspan(std::min(entry_head, entry.size())), {"esds"});
    if (esds.size() < 4) return input_error("its scene has no description (esds)");
    TRY_ASSIGN(const auto outer, descriptors_in(esds.subspan(4)));
    const Descriptor* const stream = with_tag(outer, 3);
    if (!stream || stream->content.size() < 3) return input_error("its scene has no descriptor of a stream");
    const std::uint8_t flags = stream->content[2];
    std::size_t skipped = 3;
    if (flags & 0x80) skipped += 2;                                           // depends on a stream
    if (flags & 0x40) skipped += 1 + number_at(stream->content, skipped, 1);  // an address
    if (flags & 0x20) skipped += 2;                                           // a clock
    TRY_ASSIGN(const auto inner,
               descriptors_in(stream->content.subspan(std::min(skipped, stream->content.size()))));
    const Descriptor* const decoder = with_tag(inner, 4);
    constexpr std::size_t decoder_head = 13;
    if (!decoder || decoder->content.size() < decoder_head)
        return input_error("its scene does not say what decodes it");
    TRY_ASSIGN(const auto info, descriptors_in(decoder->content.subspan(decoder_head)));
    const Descriptor* const config = with_tag(info, 5);
    if (!config) return input_error("its scene has no configuration");
    return decode_config(config->content, decoder->content[0]);
}

/// Commands that say which stream each object is; those that say something else say nothing here.
Result<std::map<std::uint16_t, std::uint32_t>> objects_in(BytesView sample, BytesView referred) {
    std::map<std::uint16_t, std::uint32_t> objects;
    TRY_ASSIGN(const auto commands, descriptors_in(sample));
    for (const Descriptor& command : commands) {
        if (command.tag != 1) continue;
        TRY_ASSIGN(const auto found, descriptors_in(command.content));
        for (const Descriptor& object : found) {
            if ((object.tag != 0x11 && object.tag != 1) || object.content.size() < 2) continue;
            const auto number = static_cast<std::uint16_t>(number_at(object.content, 0, 2) >> 6);
            if (number_at(object.content, 0, 2) & 0x20) continue;  // elsewhere, by an address
            TRY_ASSIGN(const auto streams, descriptors_in(object.content.subspan(2)));
            const Descriptor* const reference = with_tag(streams, 0x0F);
            const std::uint64_t place = reference ? number_at(reference->content, 0, 2) : 0;
            if (place == 0 || 4 * place > referred.size())
                return input_error("object " + std::to_string(number) + " is stream " +
                                   std::to_string(place) + ": must be 1 to " +
                                   std::to_string(referred.size() / 4));
            objects[number] = static_cast<std::uint32_t>(number_at(referred, 4 * (place - 1), 4));
        }
    }
    return objects;
}

}  // namespace

Result<FirstSample> first_sample_of(BytesView moov, std::uint32_t track) {
    TRY_ASSIGN(const auto boxes, boxes_in(moov));
    for (const Track& each : tracks_of(boxes))
        if (each.id == track) return first_sample_of(each);
    return input_error("has no track " + std::to_string(track));
}

Result<std::optional<SceneStream>> read_scene_stream(BytesView moov, const ReadBytes& read) {
    TRY_ASSIGN(const auto boxes, boxes_in(moov));
    const auto tracks = tracks_of(boxes);
    const auto with_handler = [&](std::string_view handler) {
        return std::find_if(tracks.begin(), tracks.end(),
                            [&](const Track& each) { return each.handler == handler; });
    };
    const auto scene = with_handler("sdsm"), objects = with_handler("odsm");
    if (scene == tracks.end()) return std::optional<SceneStream>();
    SceneStream made;
    TRY_ASSIGN(const auto config, config_of(*scene));
    made.config = config;
    TRY_ASSIGN(auto sample, first_sample(*scene, read));
    made.scene = std::move(sample);
    if (objects == tracks.end()) return std::optional(std::move(made));
    TRY_ASSIGN(const auto descriptors, first_sample(*objects, read));
    TRY_ASSIGN(auto found, objects_in(descriptors, content_at(objects->content, {"tref", "mpod"})));
    made.objects = std::move(found);
    return std::optional(std::move(made));
}

}  // namespace touchable::mpeg4
