// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/mpeg4/boxes.hpp"

namespace touchable::mpeg4 {

namespace {

constexpr std::uint64_t most_sample_bytes = 64 << 10;

// Tags and numbers of ISO/IEC 14496-1.
constexpr std::uint8_t es_descriptor = 0x03, decoder_config = 0x04, decoder_info = 0x05, sync_config = 0x06,
                       track_included = 0x0E, track_referenced = 0x0F, initial_object = 0x10, object = 0x11,
                       object_in_stream = 0x01, object_update = 0x01;
constexpr int object_stream = 1, scene_stream = 3;
constexpr std::uint8_t object_stream_type = 1;  // objectTypeIndication: MPEG-4 Systems
constexpr std::uint32_t timescale = 1000;

/// A descriptor of MPEG-4 Systems: a tag, a length, and a content.
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
    return named_in(all, tag, &Descriptor::tag);
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
        tracks.push_back({number_behind_times(head),
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

/// The first sample, which holds everything.
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
    const Descriptor* const stream = with_tag(outer, es_descriptor);
    if (!stream || stream->content.size() < 3) return input_error("its scene has no descriptor of a stream");
    const std::uint8_t flags = stream->content[2];
    std::size_t skipped = 3;
    if (flags & 0x80) skipped += 2;                                           // depends on a stream
    if (flags & 0x40) skipped += 1 + number_at(stream->content, skipped, 1);  // an address
    if (flags & 0x20) skipped += 2;                                           // a clock
    TRY_ASSIGN(const auto inner,
               descriptors_in(stream->content.subspan(std::min(skipped, stream->content.size()))));
    const Descriptor* const decoder = with_tag(inner, decoder_config);
    constexpr std::size_t decoder_head = 13;
    if (!decoder || decoder->content.size() < decoder_head)
        return input_error("its scene does not say what decodes it");
    TRY_ASSIGN(const auto info, descriptors_in(decoder->content.subspan(decoder_head)));
    const Descriptor* const config = with_tag(info, decoder_info);
    if (!config) return input_error("its scene has no configuration");
    return decode_config(config->content, decoder->content[0]);
}

/// Reads the commands that say which stream each object is; ignores others.
Result<std::map<std::uint16_t, std::uint32_t>> objects_in(BytesView sample, BytesView referred) {
    std::map<std::uint16_t, std::uint32_t> objects;
    TRY_ASSIGN(const auto commands, descriptors_in(sample));
    for (const Descriptor& command : commands) {
        if (command.tag != object_update) continue;
        TRY_ASSIGN(const auto found, descriptors_in(command.content));
        for (const Descriptor& each : found) {
            if ((each.tag != object && each.tag != object_in_stream) || each.content.size() < 2) continue;
            const auto number = static_cast<std::uint16_t>(number_at(each.content, 0, 2) >> 6);
            if (number_at(each.content, 0, 2) & 0x20) continue;  // elsewhere, by an address
            TRY_ASSIGN(const auto streams, descriptors_in(each.content.subspan(2)));
            const Descriptor* const reference = with_tag(streams, track_referenced);
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

/// The length takes more than one byte from 128 bytes on.
Bytes descriptor(std::uint8_t tag, BytesView content) {
    Bytes made{tag};
    int bytes = 1;
    while (content.size() >> (7 * bytes) != 0) ++bytes;
    for (int k = bytes - 1; k >= 0; --k)
        made.push_back(static_cast<std::uint8_t>((content.size() >> (7 * k) & 127) | (k > 0 ? 128 : 0)));
    put_bytes(made, content);
    return made;
}

Bytes full_box(std::string_view type, std::uint32_t flags, const Bytes& content) {
    Bytes body = packed_numbers({{flags, 4}});
    put_bytes(body, content);
    return box_of(type, body);
}

void put_matrix(Bytes& to) {  // the identity
    constexpr std::uint32_t one = 0x10000, last = 0x40000000;
    for (const std::uint32_t each : {one, 0U, 0U, 0U, one, 0U, 0U, 0U, last}) put_number(to, each, 4);
}

/// A track of MPEG-4 Systems with one sample, shown from the beginning to the end.
struct SystemsTrack {
    std::uint32_t id = 0;
    const char* handler = "";
    int stream_type = 0;
    std::uint8_t object_type = 0;
    Bytes decoder_info{};
    BytesView sample{};
    std::uint64_t at = 0;                    // of the sample in the file
    std::vector<std::uint32_t> refers_to{};  // by mpod
};

Bytes esds(const SystemsTrack& track) {
    Bytes config{track.object_type, static_cast<std::uint8_t>(track.stream_type << 2 | 1)};
    put_number(config, track.sample.size(), 3);
    put_bytes(config, Bytes(8));  // rates: not stated
    if (!track.decoder_info.empty()) put_bytes(config, descriptor(decoder_info, track.decoder_info));
    Bytes stream(3);  // its number is the track's, in a file
    put_bytes(stream, descriptor(decoder_config, config));
    put_bytes(stream, descriptor(sync_config, Bytes{2}));
    return full_box("esds", 0, descriptor(es_descriptor, stream));
}

Bytes sample_tables(const SystemsTrack& track, std::uint64_t duration) {
    Bytes entry = packed_numbers({{0, 6}, {1, 2}});  // which data reference
    put_bytes(entry, esds(track));
    Bytes tables;
    const auto table = [&tables](const char* type, std::initializer_list<std::uint64_t> numbers) {
        Bytes content;
        for (const std::uint64_t each : numbers) put_number(content, each, 4);
        put_bytes(tables, full_box(type, 0, content));
    };
    Bytes kinds = packed_numbers({{1, 4}});
    put_box(kinds, "mp4s", entry);
    put_bytes(tables, full_box("stsd", 0, kinds));
    table("stts", {1, 1, duration});
    table("stsc", {1, 1, 1, 1});
    table("stsz", {0, 1, track.sample.size()});
    put_bytes(tables, full_box("co64", 0, packed_numbers({{1, 4}, {track.at, 8}})));
    return tables;
}

Bytes systems_trak(const SystemsTrack& track, std::uint64_t movie_duration, std::uint64_t duration) {
    constexpr std::uint64_t no_dates = 0;
    Bytes head = packed_numbers({{no_dates, 8}, {track.id, 4}, {0, 4}, {movie_duration, 4}});
    put_bytes(head, Bytes(16));
    put_matrix(head);
    put_bytes(head, Bytes(8));
    Bytes trak = full_box("tkhd", 1, head);
    if (!track.refers_to.empty()) {
        Bytes ids;
        for (const std::uint32_t id : track.refers_to) put_number(ids, id, 4);
        put_box(trak, "tref", box_of("mpod", ids));
    }
    constexpr std::uint64_t no_language = 0x55C4;  // und
    const Bytes times =
        packed_numbers({{no_dates, 8}, {timescale, 4}, {duration, 4}, {no_language, 2}, {0, 2}});
    Bytes handler(4);
    for (const char* letter = track.handler; *letter; ++letter)
        handler.push_back(static_cast<std::uint8_t>(*letter));
    put_bytes(handler, Bytes(13));
    Bytes itself = packed_numbers({{1, 4}});
    put_bytes(itself, full_box("url ", 1, {}));
    Bytes information = full_box("nmhd", 0, {});
    put_box(information, "dinf", full_box("dref", 0, itself));
    put_box(information, "stbl", sample_tables(track, duration));
    Bytes media = full_box("mdhd", 0, times);
    put_bytes(media, full_box("hdlr", 0, handler));
    put_box(media, "minf", information);
    put_box(trak, "mdia", media);
    return box_of("trak", trak);
}

/// States which track each object is: by its place among the tracks that the descriptors' track refers to.
Bytes object_descriptors(const SceneStream& stream) {
    Bytes all;
    std::uint32_t place = 0;
    for ([[maybe_unused]] const auto& [number, track] : stream.objects) {
        constexpr std::uint64_t no_url = 0x1F;  // five reserved bits
        Bytes content = packed_numbers({{static_cast<std::uint64_t>(number) << 6 | no_url, 2}});
        put_bytes(content, descriptor(track_referenced, packed_numbers({{++place, 2}})));
        put_bytes(all, descriptor(object, content));
    }
    return descriptor(object_update, all);
}

Bytes initial_object_descriptor(std::uint32_t scene_track, std::uint32_t object_track) {
    // Number 1, no URL, profiles not in line, reserved bits.
    Bytes content = packed_numbers({{1 << 6 | 0x0F, 2}});
    put_bytes(content, Bytes(5, 0xFF));  // no capability is required
    for (const std::uint32_t track : {scene_track, object_track})
        put_bytes(content, descriptor(track_included, packed_numbers({{track, 4}})));
    return full_box("iods", 0, descriptor(initial_object, content));
}

std::uint32_t track_id(BytesView trak) {
    return number_behind_times(content_at(trak, {"tkhd"}));
}

bool shows_pictures(BytesView trak) {
    return number_at(content_at(trak, {"mdia", "hdlr"}), 8, 4) == 0x76696465;  // vide
}

/// The same track, enabled: MPEG-4 Systems ignore the object of a track that is not.
Bytes enabled(BytesView trak) {
    constexpr std::string_view head[] = {"tkhd"};
    const BytesView before = content_at(trak, {"tkhd"});
    constexpr std::size_t last_flags = 3;
    if (before.size() <= last_flags) return {trak.begin(), trak.end()};
    Bytes after(before.begin(), before.end());
    after[last_flags] |= 1;
    return with_content(trak, head, after);
}

/// The same track, marked as auxiliary to `shown` if it has pictures and is not that one.
Result<Bytes> marked(BytesView trak, std::uint32_t shown) {
    if (track_id(trak) == shown || !shows_pictures(trak)) return Bytes(trak.begin(), trak.end());
    constexpr std::string_view auxv = "auxv";
    constexpr std::string_view handler[] = {"mdia", "hdlr"};
    const BytesView kind = content_at(trak, {"mdia", "hdlr"});
    Bytes auxiliary(kind.begin(), kind.end());
    std::copy(auxv.begin(), auxv.end(), auxiliary.begin() + 8);
    const Bytes changed = with_content(trak, handler, auxiliary);
    TRY_ASSIGN(const auto parts, boxes_in(changed));
    Bytes made;
    for (const Box& part : parts) {
        if (part.type == "mdia") put_box(made, "tref", box_of("vdep", packed_numbers({{shown, 4}})));
        put_box(made, part.type, part.content);
    }
    return made;
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
        return std::ranges::find(tracks, handler, &Track::handler);
    };
    const auto scene = with_handler("sdsm"), objects = with_handler("odsm");
    if (scene == tracks.end()) return std::optional<SceneStream>();
    SceneStream made;
    TRY_ASSIGN(made.config, config_of(*scene));
    TRY_ASSIGN(made.scene, first_sample(*scene, read));
    if (objects == tracks.end()) return std::optional(std::move(made));
    TRY_ASSIGN(const auto descriptors, first_sample(*objects, read));
    TRY_ASSIGN(made.objects, objects_in(descriptors, content_at(objects->content, {"tref", "mpod"})));
    return std::optional(std::move(made));
}

Result<Bytes> with_scene_stream(BytesView moov, const SceneStream& stream, std::uint32_t shown,
                                std::uint64_t at) {
    TRY_ASSIGN(const auto parts, boxes_in(moov));
    const Box* const head = box_named(parts, "mvhd");
    if (!head || head->content.size() < 100) return input_error("its movie box has no header (mvhd)");
    const bool is_long = head->content[0] == 1;
    const std::uint64_t movie_timescale = number_at(head->content, is_long ? 20 : 12, 4);
    const std::uint64_t movie_duration = number_at(head->content, is_long ? 24 : 16, is_long ? 8 : 4);
    if (movie_timescale == 0) return input_error("its movie has no time scale");
    std::uint32_t free_id = 1;
    for (const Box& part : parts)
        if (part.type == "trak") free_id = std::max(free_id, track_id(part.content) + 1);

    const Bytes objects = object_descriptors(stream);
    Bytes scene = stream.scene;
    scene.push_back(0);  // some decoders do not read the last byte (docs/codecs.md)
    Bytes samples = scene;
    put_bytes(samples, objects);
    SystemsTrack scenes{
        free_id, "sdsm", scene_stream, stream.config.object_type(), encode_config(stream.config),
        scene,   at + 8};
    SystemsTrack descriptors{free_id + 1, "odsm",  object_stream,        object_stream_type,
                             {},          objects, at + 8 + scene.size()};
    for (const auto& [number, track] : stream.objects) descriptors.refers_to.push_back(track);

    const std::uint64_t duration = movie_duration * timescale / movie_timescale;
    Bytes header(head->content.begin(), head->content.end());
    const Bytes next = packed_numbers({{free_id + 2, 4}});
    std::copy(next.begin(), next.end(), header.end() - 4);
    Bytes movie;
    put_box(movie, "mvhd", header);
    put_bytes(movie, initial_object_descriptor(scenes.id, descriptors.id));
    bool are_added = false;
    const auto add_tracks = [&] {
        for (const SystemsTrack* track : {&scenes, &descriptors})
            put_bytes(movie, systems_trak(*track, movie_duration, duration));
        are_added = true;
    };
    for (const Box& part : parts) {
        if (part.type == "mvhd" || part.type == "iods") continue;
        if (part.type != "trak") {
            if (!are_added) add_tracks();
            put_box(movie, part.type, part.content);
        } else {
            TRY_ASSIGN(const auto trak, marked(part.content, shown));
            const bool is_object = std::ranges::any_of(
                stream.objects,
                [id = track_id(part.content)](const auto& object) { return object.second == id; });
            put_box(movie, "trak", is_object ? enabled(trak) : trak);
        }
    }
    if (!are_added) add_tracks();
    Bytes made = box_of("mdat", samples);
    put_box(made, "moov", movie);
    return made;
}

Result<Bytes> with_auxiliary_tracks(BytesView moov, std::uint32_t shown) {
    TRY_ASSIGN(const auto parts, boxes_in(moov));
    Bytes movie;
    for (const Box& part : parts) {
        TRY_ASSIGN(const auto content, part.type == "trak"
                                           ? marked(part.content, shown)
                                           : Result<Bytes>(Bytes(part.content.begin(), part.content.end())));
        put_box(movie, part.type, content);
    }
    return movie;
}

}  // namespace touchable::mpeg4
