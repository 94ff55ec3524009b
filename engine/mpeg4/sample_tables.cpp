#include "engine/mpeg4/sample_tables.hpp"

#include <algorithm>
#include <string>

#include "engine/base/try.hpp"

namespace touchable::mpeg4 {
namespace {

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

/// What a table of runs says of each sample: of so many in a row the same number.
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
    if (keys.bytes.empty()) return {};  // all are
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
        if (!table->ok()) return table->error();
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

/// A box with a version, and a list of entries behind their number.
class List {
public:
    void put(std::uint64_t number, int bytes = 4) { put_number(entries_, number, bytes); }
    void end_entry() { ++count_; }
    Bytes box(std::string_view type, int version = 0) const {
        Bytes content;
        put_number(content, static_cast<std::uint64_t>(version) << 24, 4);
        put_number(content, count_, 4);
        put_bytes(content, entries_);
        return box_of(type, content);
    }

private:
    Bytes entries_;
    std::uint64_t count_ = 0;
};

/// So many in a row the same number.
template <class Number>
List runs_of(const std::vector<Sample>& samples, Number number) {
    List runs;
    for (std::size_t k = 0; k < samples.size();) {
        std::size_t end = k + 1;
        while (end < samples.size() && number(samples[end]) == number(samples[k])) ++end;
        runs.put(end - k);
        runs.put(number(samples[k]));
        runs.end_entry();
        k = end;
    }
    return runs;
}

}  // namespace

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

Bytes tables_of(const TrackSamples& track, std::uint64_t later) {
    const auto& samples = track.samples;
    Bytes all = runs_of(samples, [](const Sample& s) { return s.duration; }).box("stts");
    if (std::any_of(samples.begin(), samples.end(), [](const Sample& s) { return s.shown_later != 0; }))
        put_bytes(all, runs_of(samples, [](const Sample& s) {
                           return static_cast<std::uint32_t>(s.shown_later);
                       }).box("ctts", 1));
    List keys, chunks, places;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (!samples[k].is_key) continue;
        keys.put(k + 1);
        keys.end_entry();
    }
    Bytes sizes;
    put_number(sizes, 0, 8);
    put_number(sizes, samples.size(), 4);
    for (const Sample& sample : samples) put_number(sizes, sample.bytes, 4);
    for (std::size_t k = 0; k < track.chunks.size(); ++k) {
        const Chunk& chunk = track.chunks[k];
        for (const std::uint64_t number :
             {std::uint64_t{k + 1}, std::uint64_t{chunk.samples}, std::uint64_t{chunk.description}})
            chunks.put(number);
        chunks.end_entry();
        places.put(chunk.at + later, 8);
        places.end_entry();
    }
    put_bytes(all, keys.box("stss"));
    put_box(all, "stsz", sizes);
    put_bytes(all, chunks.box("stsc"));
    put_bytes(all, places.box("co64"));
    return all;
}

}  // namespace touchable::mpeg4
