// SPDX-License-Identifier: Apache-2.0
#include "engine/mpeg4/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable::mpeg4 {

namespace {

constexpr std::size_t most_boxes = 1 << 16;
/// Limits of a movie box without its tables, and of a table that stays.
constexpr std::size_t most_head_bytes = std::size_t{16} << 20, longest_table = std::size_t{64} << 10;
constexpr int most_nested = 8;

bool is_box_of_boxes(std::string_view type) {
    constexpr std::string_view known[] = {"trak", "mdia", "minf", "stbl", "udta", "meta"};
    return std::ranges::find(known, type) != std::end(known);
}

/// The boxes between two places, without long tables inside them either.
Result<Bytes> heads_between(ByteSource& file, std::uint64_t at, std::uint64_t end, int depth) {
    Bytes heads;
    while (at + 8 <= end) {
        TRY_ASSIGN(const auto box, box_at(file, at, end));
        if (!box) return input_error("a box at byte " + std::to_string(at) + " is longer than what it is in");
        const std::uint64_t size = box->end - box->content;
        at = box->end;
        const bool opens = size > longest_table && depth < most_nested && is_box_of_boxes(box->type);
        if (!opens && size > longest_table) continue;
        const std::uint64_t version_bytes = opens && box->type == "meta" ? 4 : 0;
        TRY_ASSIGN(auto content, bytes_at(file, box->content, opens ? version_bytes : size));
        if (opens) {
            TRY_ASSIGN(const auto inner,
                       heads_between(file, box->content + version_bytes, box->end, depth + 1));
            put_bytes(content, inner);
        }
        put_box(heads, box->type, content);
        if (heads.size() > most_head_bytes)
            return input_error("its movie box has more than 16 MiB beside its tables");
    }
    return heads;
}

/// A sample of a track, such as a picture.
struct Sample {
    std::uint32_t bytes = 0;
    std::uint32_t duration = 0;    ///< until the next one is decoded, in the track's time scale
    std::int32_t shown_later = 0;  ///< time from decoding to display
    bool is_key = true;            ///< decoding can begin with it
};
/// Samples that follow each other in the file.
struct Chunk {
    std::uint64_t at = 0;
    std::uint32_t samples = 0;
    std::uint32_t description = 1;  ///< which entry of the track's stsd
};
/// All samples of a track, in the order of decoding.
struct TrackSamples {
    std::vector<Sample> samples;
    std::vector<Chunk> chunks;
};

constexpr std::size_t table_head = 8;  // version, flags, and how many entries

/// The entries of a table, each of some numbers of four bytes.
struct Table {
    BytesView bytes;
    std::size_t numbers = 1;  // of an entry
    std::size_t count = 0;
    std::uint64_t at(std::size_t entry, std::size_t number = 0) const {
        return number_at(bytes, table_head + 4 * (numbers * entry + number), 4);
    }
};

Result<Table> table_in(BytesView stbl, std::string_view type, std::size_t numbers) {
    const BytesView bytes = content_at(stbl, {type});
    const std::uint64_t count = bytes.size() < table_head ? 0 : number_at(bytes, 4, 4);
    if (count > 0 && count > (bytes.size() - table_head) / (4 * numbers))
        return input_error("its table " + std::string(type) + " claims " + std::to_string(count) +
                           " entries in " + std::to_string(bytes.size()) + " bytes");
    return Table{bytes, numbers, count};
}

Error contradiction(std::string_view type, std::size_t samples) {
    return input_error("its table " + std::string(type) + " is not of its " + std::to_string(samples) +
                       " samples");
}

/// Calls `put(index, number)` for each sample of a table of runs: counts, each with their number.
template <class Put>
Result<void> each_in_runs(BytesView stbl, std::string_view type, std::size_t samples, Put put) {
    TRY_ASSIGN(const auto runs, table_in(stbl, type, 2));
    std::size_t next = 0;
    for (std::size_t k = 0; k < runs.count; ++k) {
        const std::uint64_t length = runs.at(k);
        if (length > samples - next) return contradiction(type, samples);
        for (std::uint64_t n = 0; n < length; ++n) put(next++, static_cast<std::uint32_t>(runs.at(k, 1)));
    }
    return runs.count == 0 || next == samples ? Result<void>() : contradiction(type, samples);
}

Result<void> read_sizes(BytesView stbl, std::size_t most, std::vector<Sample>& to) {
    const BytesView sizes = content_at(stbl, {"stsz"});
    constexpr std::size_t head = 12;
    if (sizes.size() < head) return {};
    const std::uint64_t same = number_at(sizes, 4, 4), count = number_at(sizes, 8, 4);
    if (count > most || (same == 0 && count > (sizes.size() - head) / 4))
        return input_error("its table stsz claims " + std::to_string(count) + " samples");
    to.resize(count);
    for (std::size_t k = 0; k < count; ++k)
        to[k].bytes = static_cast<std::uint32_t>(same != 0 ? same : number_at(sizes, head + 4 * k, 4));
    return {};
}

Result<void> read_keys(BytesView stbl, std::vector<Sample>& to) {
    TRY_ASSIGN(const auto keys, table_in(stbl, "stss", 1));
    if (keys.bytes.empty()) return {};  // all samples are keys
    for (Sample& sample : to) sample.is_key = false;
    for (std::size_t k = 0; k < keys.count; ++k) {
        const std::uint64_t number = keys.at(k);
        if (number < 1 || number > to.size()) return contradiction("stss", to.size());
        to[number - 1].is_key = true;
    }
    return {};
}

Result<void> read_chunks(BytesView stbl, TrackSamples& to) {
    const auto near = table_in(stbl, "stco", 1), far = table_in(stbl, "co64", 2),
               runs = table_in(stbl, "stsc", 3);
    for (const auto* table : {&near, &far, &runs})
        if (!*table) return table->error();
    const Table& places = near->count > 0 ? *near : *far;
    std::size_t run = 0, next = 0;
    for (std::size_t k = 0; k < places.count; ++k) {
        while (run + 1 < runs->count && runs->at(run + 1) <= k + 1) ++run;
        const std::uint64_t samples = runs->count > 0 ? runs->at(run, 1) : 0;
        if (samples > to.samples.size() - next) return contradiction("stsc", to.samples.size());
        next += samples;
        to.chunks.push_back({number_at(places.bytes, table_head + 4 * places.numbers * k,
                                       static_cast<int>(4 * places.numbers)),
                             static_cast<std::uint32_t>(samples),
                             static_cast<std::uint32_t>(runs->at(run, 2))});
    }
    return next == to.samples.size() ? Result<void>() : contradiction("stsc", to.samples.size());
}

/// A box with a version, a count, and so many entries.
class List {
public:
    void add(std::initializer_list<std::uint64_t> entry, int bytes = 4) {
        for (const std::uint64_t number : entry) put_number(entries_, number, bytes);
        ++count_;
    }
    Bytes box(std::string_view type, int version = 0) const {
        Bytes content = packed_numbers({{static_cast<std::uint64_t>(version) << 24, 4}, {count_, 4}});
        put_bytes(content, entries_);
        return box_of(type, content);
    }

private:
    Bytes entries_;
    std::uint64_t count_ = 0;
};

/// A table of runs of the same number.
template <class Number>
List runs_of(const std::vector<Sample>& samples, Number number) {
    List runs;
    for (std::size_t k = 0; k < samples.size();) {
        std::size_t end = k + 1;
        while (end < samples.size() && number(samples[end]) == number(samples[k])) ++end;
        runs.add({end - k, number(samples[k])});
        k = end;
    }
    return runs;
}

/// Reads a track's tables of samples (box stbl); no samples if they are empty. An error if they contradict
/// each other or have more than `most`.
Result<TrackSamples> samples_in(BytesView stbl, std::size_t most) {
    TrackSamples track;
    std::vector<Sample>& samples = track.samples;
    TRY(read_sizes(stbl, most, samples));
    TRY(each_in_runs(stbl, "stts", samples.size(),
                     [&](std::size_t k, std::uint32_t number) { samples[k].duration = number; }));
    TRY(each_in_runs(stbl, "ctts", samples.size(), [&](std::size_t k, std::uint32_t number) {
        samples[k].shown_later = static_cast<std::int32_t>(number);
    }));
    TRY(read_keys(stbl, samples));
    TRY(read_chunks(stbl, track));
    return track;
}

/// The tables of these samples, which are `later` bytes later in a file: all boxes of a stbl except its stsd.
Bytes tables_of(const TrackSamples& track, std::uint64_t later) {
    const auto& samples = track.samples;
    Bytes all = runs_of(samples, [](const Sample& s) { return s.duration; }).box("stts");
    if (std::ranges::any_of(samples, [](const Sample& s) { return s.shown_later != 0; }))
        put_bytes(all, runs_of(samples, [](const Sample& s) {
                           return static_cast<std::uint32_t>(s.shown_later);
                       }).box("ctts", 1));
    List keys, chunks, places;
    for (std::size_t k = 0; k < samples.size(); ++k)
        if (samples[k].is_key) keys.add({k + 1});
    Bytes sizes = packed_numbers({{0, 8}, {samples.size(), 4}});
    for (const Sample& sample : samples) put_number(sizes, sample.bytes, 4);
    for (std::size_t k = 0; k < track.chunks.size(); ++k) {
        const Chunk& chunk = track.chunks[k];
        chunks.add({k + 1, chunk.samples, chunk.description});
        places.add({chunk.at + later}, 8);
    }
    put_bytes(all, keys.box("stss"));
    put_box(all, "stsz", sizes);
    put_bytes(all, chunks.box("stsc"));
    put_bytes(all, places.box("co64"));
    return all;
}

constexpr std::uint64_t most_box_bytes = std::uint64_t{64} << 20;
constexpr std::uint64_t most_samples = std::uint64_t{1} << 23;

/// Values of a sample that its fragment does not state.
struct SampleDefaults {
    std::uint32_t description = 1, duration = 0, bytes = 0, flags = 0;
};

struct PictureTrack {
    std::uint32_t id = 0;
    BytesView trak{};
    bool has_pictures = false;
    std::uint32_t timescale = 0;
    SampleDefaults defaults{};
    TrackSamples all{};
    std::uint64_t begin = 0, end = 0;  // decoding times
};

/// A run of samples (trun) of a fragment.
struct FragmentRun {
    PictureTrack* track = nullptr;
    std::optional<std::uint64_t> time{};  // if the fragment states it
    Chunk chunk{};
    std::vector<Sample> samples{};
};

bool is_picture_handler(BytesView trak) {
    const std::uint64_t handler = number_at(content_at(trak, {"mdia", "hdlr"}), 8, 4);
    return handler == 0x76696465 || handler == 0x61757876;  // vide, auxv
}

/// Writes a number of a box with a version: of four bytes or, from version 1 on, of eight.
void put_versioned(Bytes& box, std::size_t at, std::size_t at_when_long, std::uint64_t number) {
    const bool is_long = !box.empty() && box[0] == 1;
    Bytes bytes;
    put_number(bytes, is_long ? number : std::min<std::uint64_t>(number, 0xFFFFFFFF), is_long ? 8 : 4);
    const std::size_t from = is_long ? at_when_long : at;
    if (from + bytes.size() <= box.size())
        std::copy(bytes.begin(), bytes.end(), box.begin() + static_cast<std::ptrdiff_t>(from));
}

/// The edits of what is played: one without an end (0), as in fragmented files, becomes as long as the track.
Bytes with_duration(BytesView edits, std::uint64_t duration) {
    Bytes made(edits.begin(), edits.end());
    constexpr std::size_t head = 8;
    const std::size_t bytes = !made.empty() && made[0] == 1 ? 8 : 4, entry = 2 * bytes + 4;
    for (std::size_t at = head; at + entry <= made.size(); at += entry) {
        const bool is_pause = (made[at + bytes] & 128) != 0;
        if (number_at(made, at, static_cast<int>(bytes)) != 0 || is_pause) continue;
        put_versioned(made, at, at, duration);
    }
    return made;
}

class Gatherer {
public:
    explicit Gatherer(ByteSource& file)
        : file_(file), most_samples_(std::min<std::uint64_t>(most_samples, file.size())) {}
    /// Returns false if the movie box announces no fragments.
    Result<bool> read_movie(const Box::Place& moov) {
        TRY_ASSIGN(const auto place, first_box(file_, "mvex", moov.content, moov.end));
        if (!place) return false;
        if (moov.end - moov.content > most_box_bytes)
            return input_error("its movie box has more than 64 MiB");
        TRY_ASSIGN(moov_, bytes_at(file_, moov.content, moov.end - moov.content));
        TRY_ASSIGN(const auto parts, boxes_in(moov_));
        const BytesView header = content_at(moov_, {"mvhd"});
        if (header.size() < 32) return input_error("its movie box has no header (mvhd)");
        timescale_ = number_behind_times(header);
        for (const Box& part : parts) {
            if (part.type != "trak") continue;
            const BytesView head = content_at(part.content, {"tkhd"}),
                            media = content_at(part.content, {"mdia", "mdhd"});
            if (head.size() < 24 || media.size() < 24) continue;
            PictureTrack& track = tracks_.emplace_back();
            track.trak = part.content;
            track.id = number_behind_times(head);
            track.timescale = number_behind_times(media);
            track.has_pictures = is_picture_handler(part.content) && track.timescale > 0;
            if (!track.has_pictures) continue;
            TRY_ASSIGN(track.all, samples_in(content_at(part.content, {"mdia", "minf", "stbl"}),
                                             most_samples_ - samples_));
            samples_ += track.all.samples.size();
            for (const Sample& sample : track.all.samples) track.end += sample.duration;
        }
        TRY_ASSIGN(const auto defaults, boxes_in(content_at(moov_, {"mvex"})));
        for (const Box& each : defaults) {
            PictureTrack* const track =
                each.type == "trex" ? track_of(number_at(each.content, 4, 4)) : nullptr;
            const auto number = [&each](std::size_t at) {
                return static_cast<std::uint32_t>(number_at(each.content, at, 4));
            };
            if (track) track->defaults = {number(8), number(12), number(16), number(20)};
        }
        return true;
    }

    /// Returns false if some of its samples are missing.
    Result<bool> add_fragment(const Box::Place& moof) {
        if (moof.end - moof.content > most_box_bytes) return input_error("has more than 64 MiB");
        TRY_ASSIGN(const auto bytes, bytes_at(file_, moof.content, moof.end - moof.content));
        TRY_ASSIGN(const auto parts, boxes_in(bytes));
        std::uint64_t data_end = moof.at;
        std::vector<FragmentRun> runs;
        for (const Box& part : parts) {
            if (part.type != "traf") continue;
            const auto whole = read_runs(part.content, moof, data_end, runs);
            if (!whole || !*whole) return whole;
        }
        for (FragmentRun& run : runs) TRY(append(run));
        return true;
    }

    Bytes head() {
        Bytes type;
        for (const char letter : std::string("isom\0\0\2\0isomiso2mp41", 20))
            type.push_back(static_cast<std::uint8_t>(letter));
        constexpr std::size_t samples_head = 16;
        const auto made = [&](std::uint64_t later) {
            Bytes head = box_of("ftyp", type);
            put_box(head, "moov", movie(later));
            put_number(head, 1, 4);
            for (const char letter : {'m', 'd', 'a', 't'}) head.push_back(static_cast<std::uint8_t>(letter));
            put_number(head, samples_head + file_.size(), 8);
            return head;
        };
        return made(made(0).size());
    }

    /// Plain files begin at time 0: the earliest track is moved there, and a track that begins later than it
    /// shows its pictures later by the difference.
    Result<void> align() {
        // Fractions of seconds in integers: a tick may be a whole frame.
        constexpr std::uint64_t latest = std::uint64_t{1} << 61;
        struct Moment {
            std::uint64_t seconds, ticks, timescale;  // ticks: beyond the seconds
            bool operator<(const Moment& other) const {
                return seconds != other.seconds ? seconds < other.seconds
                                                : ticks * other.timescale < other.ticks * timescale;
            }
            std::uint64_t in(std::uint64_t scale) const {
                return seconds * scale + ticks * scale / timescale;
            }
        };
        const auto begin_of = [](const PictureTrack& track) {
            return Moment{track.begin / track.timescale, track.begin % track.timescale, track.timescale};
        };
        std::optional<Moment> common;
        for (const PictureTrack& track : tracks_)
            if (track.has_pictures && !track.all.samples.empty() && (!common || begin_of(track) < *common))
                common = begin_of(track);
        for (PictureTrack& track : tracks_) {
            if (!track.has_pictures || track.all.samples.empty()) continue;
            const bool is_too_late = track.begin > latest || common->seconds > latest / track.timescale;
            const std::uint64_t ticks = is_too_late ? latest : track.begin - common->in(track.timescale);
            constexpr std::uint64_t most = 1 << 30;
            if (ticks > most)
                return input_error("track " + std::to_string(track.id) + " begins too late after the others");
            for (Sample& sample : track.all.samples)
                sample.shown_later = static_cast<std::int32_t>(
                    static_cast<std::uint32_t>(sample.shown_later) + static_cast<std::uint32_t>(ticks));
        }
        return {};
    }

private:
    /// Reads a track's runs in a fragment. `data_end`: of the track before, where this track's samples begin
    /// unless it states otherwise.
    Result<bool> read_runs(BytesView traf, const Box::Place& moof, std::uint64_t& data_end,
                           std::vector<FragmentRun>& runs) {
        TRY_ASSIGN(const auto parts, boxes_in(traf));
        const Box* const head = box_named(parts, "tfhd");
        if (!head || head->content.size() < 8)
            return input_error("a fragment of a track has no header (tfhd)");
        PictureTrack* const track = track_of(number_at(head->content, 4, 4));
        if (!track)
            return input_error("a fragment is of track " + std::to_string(number_at(head->content, 4, 4)) +
                               ", which is none");
        const std::uint64_t flags = number_at(head->content, 1, 3);
        std::size_t next = 8;
        const auto take = [&](std::uint64_t flag, int bytes, std::uint64_t otherwise) {
            if ((flags & flag) == 0) return otherwise;
            next += static_cast<std::size_t>(bytes);
            return number_at(head->content, next - static_cast<std::size_t>(bytes), bytes);
        };
        const std::uint64_t base = take(1, 8, flags & 0x20000 ? moof.at : data_end);
        SampleDefaults defaults = track->defaults;
        for (const auto& [flag, member] : {std::pair{0x2U, &SampleDefaults::description},
                                           {0x8U, &SampleDefaults::duration},
                                           {0x10U, &SampleDefaults::bytes},
                                           {0x20U, &SampleDefaults::flags}})
            defaults.*member = static_cast<std::uint32_t>(take(flag, 4, defaults.*member));
        std::optional<std::uint64_t> time;
        if (const Box* const decoded = box_named(parts, "tfdt"); decoded && decoded->content.size() >= 8)
            time = number_at(decoded->content, 4, decoded->content[0] == 1 ? 8 : 4);
        data_end = base;
        for (const Box& part : parts) {
            if (part.type != "trun") continue;
            FragmentRun run{.track = track->has_pictures ? track : nullptr,
                            .time = std::exchange(time, std::nullopt)};
            const auto whole = read_run(part.content, defaults, base, data_end, run);
            if (!whole || !*whole) return whole;
            if (run.track) runs.push_back(std::move(run));
        }
        return true;
    }

    /// Reads a run from `at` on, or from its stated offset to `base`; `at` becomes its end. Returns false if
    /// some of its samples are missing.
    Result<bool> read_run(BytesView trun, const SampleDefaults& defaults, std::uint64_t base,
                          std::uint64_t& at, FragmentRun& to) {
        const std::uint64_t flags = number_at(trun, 1, 3), count = number_at(trun, 4, 4);
        std::size_t next = 8;
        const auto take = [&](std::uint64_t flag, std::uint32_t otherwise) {
            if ((flags & flag) == 0) return otherwise;
            next += 4;
            return static_cast<std::uint32_t>(number_at(trun, next - 4, 4));
        };
        if (flags & 1) at = base + static_cast<std::uint64_t>(static_cast<std::int32_t>(take(1, 0)));
        const std::uint32_t first_flags = take(4, 0);
        std::size_t entry_bytes = 0;
        for (const std::uint64_t flag : {0x100, 0x200, 0x400, 0x800}) entry_bytes += flags & flag ? 4 : 0;
        samples_ += count;
        if (next > trun.size() || count * entry_bytes > trun.size() - next || samples_ > most_samples_)
            return input_error("a run (trun) claims " + std::to_string(count) + " samples in " +
                               std::to_string(trun.size()) + " bytes");
        to.chunk = {at, static_cast<std::uint32_t>(count), defaults.description};
        constexpr std::uint32_t needs_another = 0x10000;
        std::uint64_t bytes = 0;
        for (std::uint64_t k = 0; k < count; ++k) {
            Sample sample;
            sample.duration = take(0x100, defaults.duration);
            sample.bytes = take(0x200, defaults.bytes);
            const std::uint32_t own_flags = take(0x400, k == 0 && (flags & 4) ? first_flags : defaults.flags);
            sample.is_key = (own_flags & needs_another) == 0;
            sample.shown_later = static_cast<std::int32_t>(take(0x800, 0));
            bytes += sample.bytes;
            if (to.track) to.samples.push_back(sample);
        }
        if (at > file_.size() || bytes > file_.size() - at) return false;
        at += bytes;
        return true;
    }

    /// A gap between samples prolongs the last sample before it.
    Result<void> append(FragmentRun& run) {
        PictureTrack& track = *run.track;
        const std::uint64_t time = run.time.value_or(track.end);
        auto& samples = track.all.samples;
        if (samples.empty()) {
            track.begin = time;
        } else {
            const std::uint64_t longest = std::numeric_limits<std::uint32_t>::max();
            const std::uint64_t last = track.end - samples.back().duration;
            if (time < last || time - last > longest)
                return input_error("track " + std::to_string(track.id) + " goes on at " +
                                   std::to_string(time) + " of its ticks, but its last sample is at " +
                                   std::to_string(last));
            samples.back().duration = static_cast<std::uint32_t>(time - last);
        }
        track.end = time;
        for (const Sample& sample : run.samples) track.end += sample.duration;
        if (run.samples.empty()) return {};
        samples.insert(samples.end(), run.samples.begin(), run.samples.end());
        track.all.chunks.push_back(run.chunk);
        return {};
    }

    /// The movie box, with the tracks of pictures only.
    Bytes movie(std::uint64_t later) const {
        std::uint64_t duration = 0;
        for (const PictureTrack& track : tracks_)
            if (track.has_pictures) duration = std::max(duration, movie_time(track));
        const BytesView written = content_at(moov_, {"mvhd"});
        Bytes header(written.begin(), written.end());
        put_versioned(header, 16, 24, duration);
        Bytes made = box_of("mvhd", header);
        for (const PictureTrack& track : tracks_)
            if (track.has_pictures) put_box(made, "trak", trak_of(track, later));
        const auto parts = boxes_in(moov_);
        for (const Box& part : parts ? *parts : std::vector<Box>())
            if (part.type != "mvhd" && part.type != "mvex" && part.type != "trak")
                put_box(made, part.type, part.content);
        return made;
    }

    /// The track's own boxes, with new tables of samples.
    Bytes trak_of(const PictureTrack& track, std::uint64_t later) const {
        constexpr std::string_view edits[] = {"edts", "elst"}, tables[] = {"mdia", "minf", "stbl"};
        Bytes samples = box_of("stsd", content_at(track.trak, {"mdia", "minf", "stbl", "stsd"}));
        put_bytes(samples, tables_of(track.all, later));
        const Bytes played = with_duration(content_at(track.trak, {"edts", "elst"}), movie_time(track));
        return with_content(with_content(track.trak, edits, played), tables, samples);
    }

    PictureTrack* track_of(std::uint64_t id) { return named_in(tracks_, id, &PictureTrack::id); }

    /// A track's length in the movie's time scale.
    std::uint64_t movie_time(const PictureTrack& track) const {
        const double ticks = static_cast<double>(track.end - track.begin) * timescale_ / track.timescale;
        constexpr double most = 1e18;
        return static_cast<std::uint64_t>(std::ceil(std::min(ticks, most)));
    }

    ByteSource& file_;
    Bytes moov_;
    std::uint32_t timescale_ = 0;
    std::vector<PictureTrack> tracks_;
    const std::uint64_t most_samples_;  // each has a byte or more
    std::uint64_t samples_ = 0;
};

class PlainFile final : public ByteSource {
public:
    PlainFile(const GatheredMovie& movie, std::unique_ptr<ByteSource> file)
        : head_(movie.head), size_(movie.head.size() + movie.size), file_(std::move(file)) {}
    std::uint64_t size() const override { return size_; }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        const auto of_head = static_cast<std::size_t>(
            at < head_.size() ? std::min<std::uint64_t>(count, head_.size() - at) : 0);
        if (of_head > 0) std::memcpy(to, head_.data() + at, of_head);
        if (of_head == count) return {};
        return file_->read(at + of_head - head_.size(), to + of_head, count - of_head);
    }

private:
    Bytes head_;
    std::uint64_t size_;
    std::unique_ptr<ByteSource> file_;
};

}  // namespace

Result<std::vector<Box>> boxes_in(BytesView bytes) {
    std::vector<Box> boxes;
    while (!bytes.empty()) {
        // A few zeros at the end are a QuickTime writer's end of its list.
        if (bytes.size() < 8 && std::ranges::all_of(bytes, [](std::uint8_t b) { return b == 0; })) break;
        const std::uint64_t stated = number_at(bytes, 0, 4);
        const std::uint64_t head = stated == 1 ? 16 : 8;
        if (bytes.size() < head)
            return input_error("a box is cut short: " + std::to_string(bytes.size()) + " bytes are left");
        const std::uint64_t size = stated == 0 ? bytes.size() : stated == 1 ? number_at(bytes, 8, 8) : stated;
        std::string type(reinterpret_cast<const char*>(bytes.data()) + 4, 4);
        if (size < head || size > bytes.size())
            return input_error("box " + in_quotes(type) + " has " + std::to_string(size) +
                               " bytes: must be " + std::to_string(head) + " to " +
                               std::to_string(bytes.size()));
        if (boxes.size() == most_boxes) return input_error("more than 65536 boxes in one");
        boxes.push_back({std::move(type), bytes.subspan(head, size - head)});
        bytes = bytes.subspan(size);
    }
    return boxes;
}

const Box* box_named(std::span<const Box> boxes, std::string_view type) {
    return named_in(boxes, type, &Box::type);
}

BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path) {
    for (const std::string_view type : path) {
        const auto boxes = boxes_in(bytes);
        const Box* const found = boxes ? box_named(*boxes, type) : nullptr;
        if (!found) return {};
        bytes = found->content;
    }
    return bytes;
}

Bytes with_content(BytesView bytes, std::span<const std::string_view> path, BytesView content) {
    Bytes made;
    const auto boxes = boxes_in(bytes);
    for (const Box& box : boxes ? *boxes : std::vector<Box>()) {
        if (box.type != path.front())
            put_box(made, box.type, box.content);
        else if (path.size() == 1)
            put_box(made, box.type, content);
        else
            put_box(made, box.type, with_content(box.content, path.subspan(1), content));
    }
    return made;
}

Result<std::optional<Box::Place>> box_at(ByteSource& file, std::uint64_t at, std::uint64_t end) {
    const std::uint64_t left = end - at;
    TRY_ASSIGN(const auto head, bytes_at(file, at, std::min<std::uint64_t>(16, left)));
    const std::uint64_t stated = number_at(head, 0, 4), before = stated == 1 ? 16 : 8;
    const std::uint64_t size = stated == 0 ? left : stated == 1 ? number_at(head, 8, 8) : stated;
    if (left < before) return std::optional<Box::Place>();
    std::string type(reinterpret_cast<const char*>(head.data()) + 4, 4);
    if (size < before)
        return input_error("box " + in_quotes(type) + " at byte " + std::to_string(at) + " has " +
                           std::to_string(size) + " bytes: must be " + std::to_string(before) + " at least");
    if (size > left) return std::optional<Box::Place>();
    return std::optional(Box::Place{std::move(type), at, at + before, at + size});
}

Result<std::optional<Box::Place>> first_box(ByteSource& file, std::string_view type, std::uint64_t at,
                                            std::uint64_t end) {
    while (at < end) {
        auto box = box_at(file, at, end);
        if (!box || !*box || (*box)->type == type) return box;
        at = (*box)->end;
    }
    return std::optional<Box::Place>();
}

Result<Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count) {
    if (count > file.size() || at > file.size() - count)
        return input_error("is cut short: " + std::to_string(count) + " bytes at " + std::to_string(at) +
                           " are not there");
    Bytes bytes(count);
    TRY(file.read(at, reinterpret_cast<char*>(bytes.data()), bytes.size()));
    return bytes;
}

Result<Bytes> movie_head_of(ByteSource& file) {
    TRY_ASSIGN(const auto movie, first_box(file, "moov", 0, file.size()));
    if (!movie) return Bytes();
    return heads_between(file, movie->content, movie->end, 0);
}

std::uint64_t number_at(BytesView bytes, std::size_t at, int count) {
    std::uint64_t value = 0;
    for (int k = 0; k < count; ++k) {
        const std::size_t byte = at + static_cast<std::size_t>(k);
        value = value << 8 | (byte < bytes.size() ? bytes[byte] : 0);
    }
    return value;
}

std::uint32_t number_behind_times(BytesView content) {
    return static_cast<std::uint32_t>(number_at(content, !content.empty() && content[0] == 1 ? 20 : 12, 4));
}

void put_number(Bytes& to, std::uint64_t value, int count) {
    for (int k = count - 1; k >= 0; --k) to.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

void put_bytes(Bytes& to, BytesView bytes) {
    to.insert(to.end(), bytes.begin(), bytes.end());
}

Bytes packed_numbers(std::initializer_list<std::pair<std::uint64_t, int>> numbers) {
    Bytes packed;
    for (const auto& [value, count] : numbers) put_number(packed, value, count);
    return packed;
}

void put_box(Bytes& to, std::string_view type, BytesView content) {
    put_number(to, 8 + content.size(), 4);
    for (const char letter : type) to.push_back(static_cast<std::uint8_t>(letter));
    put_bytes(to, content);
}

Bytes box_of(std::string_view type, BytesView content) {
    Bytes box;
    put_box(box, type, content);
    return box;
}

Result<std::optional<GatheredMovie>> gather_fragments(ByteSource& file) {
    Gatherer gatherer(file);
    GatheredMovie gathered;
    gathered.size = file.size();
    bool has_movie = false;
    for (std::uint64_t at = 0; at < file.size();) {
        TRY_ASSIGN(const auto box, box_at(file, at, file.size()));
        gathered.is_cut = !box.has_value();
        if (gathered.is_cut) break;
        at = box->end;
        if (box->type == "moov" && !has_movie) {
            TRY_ASSIGN(const auto is_fragmented, gatherer.read_movie(*box));
            if (!is_fragmented) return std::optional<GatheredMovie>();
            has_movie = true;
        }
        if (box->type != "moof" || !has_movie) continue;
        TRY_ASSIGN(const auto whole,
                   error_at("its fragment at byte " + std::to_string(box->at), gatherer.add_fragment(*box)));
        gathered.is_cut = !whole;
        if (gathered.is_cut) break;
    }
    if (!has_movie) return std::optional<GatheredMovie>();
    TRY(gatherer.align());
    gathered.head = gatherer.head();
    return std::optional(std::move(gathered));
}

std::unique_ptr<ByteSource> plain_file(const GatheredMovie& movie, std::unique_ptr<ByteSource> file) {
    return std::make_unique<PlainFile>(movie, std::move(file));
}

}  // namespace touchable::mpeg4
