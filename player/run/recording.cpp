// SPDX-License-Identifier: Apache-2.0
#include "player/run/run_files.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {
namespace {

// Layout: magic, version u32, fingers u32, ticks..., commands..., number of commands u64, facts (JSON), size
// of the facts u64, number of ticks u64, XXH64 of all before it u64. Format 1 has neither commands nor
// epochs. Several parts follow each other, each whole; their facts number them.
constexpr std::string_view magic = "TOUCHREC";
constexpr std::size_t head_size = 16, tail_size = 24, finger_size = 52, command_size = 28;
constexpr std::size_t tick_size(std::uint64_t version) {
    return version == 1 ? 32 : 40;
}
constexpr std::uint32_t most_fingers = 256;

void put(std::string& bytes, std::uint64_t value, int size) {
    for (int k = 0; k < size; ++k) bytes += static_cast<char>(value >> (8 * k));
}
void put(std::string& bytes, double value) {
    put(bytes, std::bit_cast<std::uint64_t>(value), 8);
}
void put(std::string& bytes, const glm::dvec3& v) {
    for (const double component : {v.x, v.y, v.z}) put(bytes, component);
}

/// Reads forward; the caller ensures that enough bytes remain.
class Bytes {
public:
    explicit Bytes(std::string_view bytes) : bytes_(bytes) {}
    std::uint64_t integer(std::size_t size) {
        return number_in_bytes(bytes_.substr(std::exchange(at_, at_ + size), size), false);
    }
    double real() { return std::bit_cast<double>(integer(8)); }
    glm::dvec3 vector() {
        const double x = real(), y = real(), z = real();
        return {x, y, z};
    }

private:
    std::string_view bytes_;
    std::size_t at_ = 0;
};

RecordedPart::Tick read_tick(Bytes& bytes, std::uint64_t version, std::size_t fingers) {
    RecordedPart::Tick tick;
    tick.time_ns = static_cast<std::int64_t>(bytes.integer(8));
    tick.frame_prev = static_cast<std::int64_t>(bytes.integer(8));
    tick.frame_next = static_cast<std::int64_t>(bytes.integer(8));
    tick.blend = bytes.real();
    if (version > 1) tick.epoch = bytes.integer(8);
    for (std::size_t k = 0; k < fingers; ++k) {
        tick.goals.push_back(bytes.vector());
        tick.forces.push_back(bytes.vector());
        tick.guards.push_back(static_cast<std::uint32_t>(bytes.integer(4)));
    }
    return tick;
}

PlaybackCommand read_command(Bytes& bytes) {
    return {.tick = static_cast<std::int64_t>(bytes.integer(8)),
            .verb = static_cast<PlaybackVerb>(bytes.integer(4)),
            .first = static_cast<std::int64_t>(bytes.integer(8)),
            .second = static_cast<std::int64_t>(bytes.integer(8))};
}

/// Why well-formed ticks are impossible; empty: they are valid.
std::string fault_of(const std::vector<RecordedPart::Tick>& ticks) {
    if (ticks.empty()) return "has no ticks; there is nothing to replay";
    for (std::size_t k = 1; k < ticks.size(); ++k) {
        if (ticks[k].time_ns < ticks[k - 1].time_ns)
            return "tick " + std::to_string(k) + ": its time is before that of the tick before";
        if (ticks[k].epoch < ticks[k - 1].epoch)
            return "tick " + std::to_string(k) + ": its epoch is before that of the tick before";
    }
    return "";
}

/// Head of a part.
struct PartHead {
    std::uint64_t version = 0, fingers = 0;
    bool operator==(const PartHead&) const = default;
};
PartHead head_of(std::string_view bytes) {
    Bytes head(bytes.substr(magic.size()));
    const std::uint64_t version = head.integer(4);
    return {version, head.integer(4)};
}

/// Layout of a part: byte offsets in the file, and counts.
struct PartPlace {
    std::uint64_t begin = 0, facts = 0, end = 0;
    std::uint64_t ticks = 0, commands = 0;
};

/// Reads a recording's bytes at any offset.
class RecordingBytes {
public:
    explicit RecordingBytes(GivenFile& file) : file_(file) {}
    std::uint64_t size() const { return file_.size(); }
    /// First read error; ranges that cannot be read are returned as zeros.
    const std::optional<Error>& failure() const { return failure_; }

    std::string of(std::uint64_t at, std::uint64_t count) {
        std::string bytes(static_cast<std::size_t>(count), '\0');
        if (auto read = file_.read(at, bytes.data(), bytes.size()); !read && !failure_)
            failure_ = read.error();
        return bytes;
    }
    std::uint64_t hash_of(std::uint64_t at, std::uint64_t count) {
        constexpr std::uint64_t step = 1 << 20;
        ByteHash hash;
        for (; count > 0 && !failure_; count -= std::min(count, step)) {
            const std::string bytes = of(at, std::min(count, step));
            hash.add(bytes.data(), bytes.size());
            at += bytes.size();
        }
        return hash.value();
    }

private:
    GivenFile& file_;
    std::optional<Error> failure_;
};

/// The part that ends at `end`, located by the sizes in its tail; nothing: impossible sizes.
std::optional<PartPlace> last_part(RecordingBytes& bytes, std::uint64_t end, const PartHead& head) {
    if (end < head_size + tail_size) return std::nullopt;
    const std::string tail_bytes = bytes.of(end - tail_size, tail_size);
    Bytes tail(tail_bytes);
    const std::uint64_t facts_size = tail.integer(8), ticks = tail.integer(8);
    std::uint64_t room = end - head_size - tail_size;
    const std::uint64_t count_size = head.version == 1 ? 0 : 8;
    if (facts_size > room || count_size > room - facts_size) return std::nullopt;
    room -= facts_size + count_size;
    const std::uint64_t facts_at = end - tail_size - facts_size;
    const std::uint64_t commands =
        head.version == 1 ? 0 : Bytes(bytes.of(facts_at - count_size, count_size)).integer(8);
    const std::uint64_t tick_bytes = tick_size(head.version) + finger_size * head.fingers;
    if (commands > room / command_size || ticks > (room - commands * command_size) / tick_bytes)
        return std::nullopt;
    const std::uint64_t begin = room - commands * command_size - ticks * tick_bytes;
    return PartPlace{begin, facts_at, end, ticks, commands};
}

/// The parts in order; nothing unless the file consists of whole parts with correct hashes.
std::optional<std::vector<PartPlace>> find_parts(RecordingBytes& bytes, const PartHead& head) {
    std::vector<PartPlace> parts;
    for (std::uint64_t end = bytes.size(); end > 0; end = parts.back().begin) {
        const auto part = last_part(bytes, end, head);
        if (!part) return std::nullopt;
        const std::string begin = bytes.of(part->begin, head_size);
        if (!begin.starts_with(magic) || head_of(begin) != head ||
            Bytes(bytes.of(end - 8, 8)).integer(8) != bytes.hash_of(part->begin, end - 8 - part->begin))
            return std::nullopt;
        parts.push_back(*part);
    }
    std::ranges::reverse(parts);
    return parts;
}

constexpr const char* damaged_words = "is damaged or cut short; it cannot be replayed";

/// Whether the facts state part `number` of `parts`; detects a file cut between two parts.
bool is_in_its_place(const nlohmann::ordered_json& facts, std::size_t number, std::size_t parts) {
    const bool numbered = facts.contains("part");
    return numbered == (number > 1) && (!numbered || facts["part"] == number) &&
           facts.contains("goes_on") == (number < parts);
}

/// Errors give the reason only, without the file's name.
Result<RecordedPart> read_part(RecordingBytes& bytes, const PartHead& head, const PartPlace& place) {
    RecordedPart part;
    part.fingers = static_cast<int>(head.fingers);
    const std::string whole = bytes.of(place.begin, place.end - place.begin);
    if (bytes.failure()) return *bytes.failure();
    Bytes body(std::string_view(whole).substr(head_size));
    for (std::uint64_t k = 0; k < place.ticks; ++k)
        part.ticks.push_back(read_tick(body, head.version, head.fingers));
    for (std::uint64_t k = 0; k < place.commands; ++k) part.playback.push_back(read_command(body));
    const std::string_view facts =
        std::string_view(whole).substr(place.facts - place.begin, place.end - tail_size - place.facts);
    try {
        (void)checked_json::parse(facts);
    } catch (const checked_json::Refusal& reason) {
        return input_error(std::string(damaged_words) + ": its facts, " + reason.message);
    }
    part.facts = nlohmann::ordered_json::parse(facts, nullptr, false);
    if (!part.facts.is_object()) return input_error(damaged_words);
    const auto named = part.facts.value("bytes", nlohmann::ordered_json::object());
    for (const auto& [key, bytes] : named.items()) {
        std::string name;
        for (const auto& byte : bytes)
            name += byte.is_number_unsigned() ? static_cast<char>(byte.get<std::uint64_t>()) : '\0';
        part.facts[key] = name;
    }
    if (const std::string fault = fault_of(part.ticks); !fault.empty()) return input_error(fault);
    TRY(validate(part.playback));
    // The clock goes through loops one by one, so the time is limited.
    if (!part.playback.empty() && part.ticks.back().time_ns > latest_moment_ns)
        return input_error("its last tick is later than 1e6 s");
    return part;
}

constexpr std::array keys{KeyedValues::Key{"depth", "mm", 0, 50}};

double scale_of(const RecordedPart& part) {
    const auto& facts = part.facts;
    return facts.contains("S") && facts["S"].is_number() ? facts["S"].get<double>() : 0;
}

/// All parts' ticks in one part, each part after the previous.
RecordedPart in_one(Recording recording) {
    RecordedPart all = std::move(recording.front());
    for (std::size_t k = 1; k < recording.size(); ++k) {
        const std::int64_t begin_ns = (all.ticks.back().time_ns / tick_ns + 1) * tick_ns;
        for (RecordedPart::Tick& tick : recording[k].ticks) {
            tick.time_ns += begin_ns;
            all.ticks.push_back(std::move(tick));
        }
    }
    return all;
}

bool same_bits(const glm::dvec3& a, const glm::dvec3& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

std::string to_text(const glm::dvec3& force, std::uint32_t guard) {
    return formatted("(%.17g, %.17g, %.17g) N with guard %u", force.x, force.y, force.z, guard);
}

std::string in_words(std::uint64_t epoch, std::int64_t prev, std::int64_t next, double blend) {
    std::string words = formatted("between frames %lld and %lld at %.17g", static_cast<long long>(prev),
                                  static_cast<long long>(next), blend);
    if (epoch > 0) words += " of epoch " + std::to_string(epoch);
    return words;
}

}  // namespace

Result<Recording> read_recording(const std::filesystem::path& file) {
    const std::string name = "recording " + file.string();
    TRY_ASSIGN(auto given, GivenFile::open(file, name, "a recording of a run"));
    RecordingBytes bytes(given);
    const std::string begin = bytes.of(0, std::min<std::uint64_t>(bytes.size(), head_size));
    if (bytes.failure()) return error_at(name, *bytes.failure());
    if (begin.size() < head_size || !begin.starts_with(magic))
        return input_error(name + ": is not a recording of a touch");
    const PartHead head = head_of(begin);
    if (head.version > recording_format_version)
        return input_error(name + ": has format version " + std::to_string(head.version) +
                           "; this program reads up to " + std::to_string(recording_format_version));
    if (head.version < 1 || head.fingers < 1 || head.fingers > most_fingers)
        return input_error(name + ": " + damaged_words);
    const auto places = find_parts(bytes, head);
    if (bytes.failure()) return error_at(name, *bytes.failure());
    if (!places) return input_error(name + ": " + damaged_words);

    Recording recording;
    std::int64_t all_ns = 0;  // total time, if there are several parts
    for (const PartPlace& place : *places) {
        const std::size_t number = recording.size() + 1;
        const std::string part_name =
            name + (places->size() > 1 ? ", part " + std::to_string(number) : std::string());
        TRY_ASSIGN(auto part, error_at(part_name, read_part(bytes, head, place)));
        if (!is_in_its_place(part.facts, number, places->size()))
            return input_error(name + ": " + damaged_words + ": a part is missing");
        const std::int64_t first_ns = part.ticks.front().time_ns, last_ns = part.ticks.back().time_ns;
        if (places->size() > 1 && (first_ns < 0 || last_ns > latest_moment_ns - all_ns))
            return input_error(part_name + ": its ticks are not within 0 and 1e6 s of the first part's");
        if (places->size() > 1) all_ns += last_ns;
        part.name = part_name;
        recording.push_back(std::move(part));
    }
    return recording;
}

Result<void> RecordingFile::add(const std::string& bytes) {
    hash_->add(bytes.data(), bytes.size());
    bytes_ += bytes.size();
    return file_->write(bytes);
}

Result<std::unique_ptr<RecordingFile>> RecordingFile::create(const std::filesystem::path& file, int fingers,
                                                             Existing existing, Pace pace, std::string name) {
    TRY_ASSIGN(auto opened, OutputFile::create(std::move(name), file, existing, pace));
    std::unique_ptr<RecordingFile> out(new RecordingFile(std::move(opened), fingers));
    TRY(out->begin_part());
    return out;
}

Result<void> RecordingFile::begin_part() {
    parts_.push_back({.begin = bytes_});
    hash_.emplace();
    std::string head(magic);
    put(head, recording_format_version, 4);
    put(head, static_cast<std::uint64_t>(fingers_), 4);
    return add(head);
}

Result<void> RecordingFile::write(const TouchTick& tick) {
    if (parts_.back().has_ended) {
        TRY(write_end(true));
        TRY(begin_part());
    }
    tick_.clear();
    for (const std::int64_t value : {tick.time_ns, tick.pair.prev.number, tick.pair.next.number})
        put(tick_, static_cast<std::uint64_t>(value), 8);
    put(tick_, tick.blend);
    put(tick_, tick.pair.epoch, 8);
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        put(tick_, tick.goals[k]);
        put(tick_, tick.forces[k].force);
        put(tick_, tick.forces[k].reasons, 4);
    }
    ++parts_.back().ticks;
    return add(tick_);
}

void RecordingFile::end_part(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback) {
    Part& part = parts_.back();
    if (part.has_ended || part.ticks == 0) return;
    part.facts = std::move(facts);
    part.playback = std::move(playback);
    part.has_ended = true;
}

Result<void> RecordingFile::finish(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback) {
    Part& part = parts_.back();
    if (!part.has_ended) part = {part.begin, part.ticks, std::move(facts), std::move(playback), true};
    if (last_frame_) {
        (void)file_->flush();
        part.ticks = ticks_up_to(*last_frame_);
        return keep_whole_ticks(*fault());
    }
    const auto ended = is_faulty() ? Result<void>() : write_end(false);
    const auto whole = ended ? file_->flush() : ended;
    if (whole) return file_->finish();
    return keep_whole_ticks(whole.error());
}

void RecordingFile::end_with_frame(std::int64_t last, const Error& why) {
    if (!last_frame_) last_frame_ = last;
    spoil(why);
}

/// Ticks of the last part before the first that needs a later frame.
std::uint64_t RecordingFile::ticks_up_to(std::int64_t frame) const {
    const std::uint64_t first = parts_.back().begin + head_size;
    std::uint64_t ticks = 0;
    for (; ticks < parts_.back().ticks; ++ticks) {
        const std::string bytes = file_->read(first + ticks * tick_bytes(), tick_bytes());
        if (bytes.empty()) break;
        Bytes tick(bytes);
        if (read_tick(tick, recording_format_version, static_cast<std::size_t>(fingers_)).frame_next > frame)
            break;
    }
    return ticks;
}

/// A part's bytes after its ticks, without the hash.
std::string RecordingFile::tail_of(std::size_t part, std::uint64_t ticks, bool goes_on) const {
    const Part& ended = parts_[part];
    std::string tail;
    for (const PlaybackCommand& command : ended.playback) {
        put(tail, static_cast<std::uint64_t>(command.tick), 8);
        put(tail, static_cast<std::uint64_t>(command.verb), 4);
        for (const std::int64_t value : {command.first, command.second})
            put(tail, static_cast<std::uint64_t>(value), 8);
    }
    put(tail, ended.playback.size(), 8);
    nlohmann::ordered_json facts = ended.facts;
    if (part > 0) facts["part"] = part + 1;
    if (goes_on) facts["goes_on"] = true;
    // File names need not be UTF-8; JSON must be: their bytes stand beside.
    const auto text_of = [](const auto& json) {
        return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    };
    for (const auto& [key, value] : ended.facts.items())
        if (value.is_string() && nlohmann::ordered_json::parse(text_of(value)) != value)
            for (const char byte : value.get_ref<const std::string&>())
                facts["bytes"][key].push_back(static_cast<unsigned char>(byte));
    const std::string text = text_of(facts);
    tail += text;
    put(tail, text.size(), 8);
    put(tail, ticks, 8);
    return tail;
}

Result<void> RecordingFile::write_end(bool goes_on) {
    std::string tail = tail_of(parts_.size() - 1, parts_.back().ticks, goes_on);
    hash_->add(tail.data(), tail.size());
    put(tail, hash_->value(), 8);
    bytes_ += tail.size();
    return file_->write(tail);
}

std::size_t RecordingFile::tick_bytes() const {
    return tick_size(recording_format_version) + finger_size * static_cast<std::size_t>(fingers_);
}

/// Ends the recording with the last part that has room for a tick and its tail.
Result<void> RecordingFile::keep_whole_ticks(const Error& why) {
    const std::uint64_t size = file_->size();
    constexpr std::uint64_t step = 1 << 16, most = 1 << 20;  // bytes that other programs may take meanwhile
    for (std::uint64_t less = 0; less <= most; less += step)
        for (std::size_t part = parts_.size(); part-- > 0;) {
            if (!parts_[part].has_ended) continue;
            parts_[part].facts["force_hash"] = ForceHash().hex();  // placeholder of the final hash's length
            const std::uint64_t needed =
                parts_[part].begin + head_size + tail_of(part, 0, false).size() + 8 + less;
            if (size < needed + tick_bytes()) continue;
            TRY_ASSIGN(const auto kept_ns,
                       end_with(part, std::min(parts_[part].ticks, (size - needed) / tick_bytes())));
            if (!kept_ns) break;
            const std::string seconds = formatted("%.3f", static_cast<double>(*kept_ns) * 1e-9);
            const std::string of_part = part > 0 ? " of part " + std::to_string(part + 1) : std::string();
            return input_error(why.message + "; it is kept, and replays, up to " + seconds + " s" + of_part);
        }
    return why;
}

/// Returns the last tick's time, ns; nothing: no room.
Result<std::optional<std::int64_t>> RecordingFile::end_with(std::size_t part, std::uint64_t ticks) {
    constexpr std::uint64_t at_once = 1024;
    const std::uint64_t first = parts_[part].begin + head_size;
    const auto fingers = static_cast<std::size_t>(fingers_);
    ByteHash hash;
    ForceHash forces;
    std::int64_t time_ns = 0;
    const std::string head = file_->read(parts_[part].begin, head_size);
    hash.add(head.data(), head.size());
    for (std::uint64_t tick = 0; tick < ticks; tick += at_once) {
        const std::uint64_t count = std::min(at_once, ticks - tick);
        const std::string bytes = file_->read(first + tick * tick_bytes(), count * tick_bytes());
        if (bytes.empty()) return input_error(file_->name() + ": cannot be read back");
        hash.add(bytes.data(), bytes.size());
        Bytes rest(bytes);
        for (std::uint64_t k = 0; k < count; ++k) {
            const RecordedPart::Tick recorded = read_tick(rest, recording_format_version, fingers);
            time_ns = recorded.time_ns;
            for (const auto& force : recorded.forces) forces.add(force);
        }
    }
    parts_[part].facts["force_hash"] = forces.hex();
    std::string tail = tail_of(part, ticks, false);
    hash.add(tail.data(), tail.size());
    put(tail, hash.value(), 8);
    TRY(file_->go_on_from(first + ticks * tick_bytes()));
    auto written = file_->write(tail);
    if (written) written = file_->flush();
    if (!written) return std::optional<std::int64_t>();
    TRY(file_->keep());
    return std::optional<std::int64_t>(time_ns);
}

Result<std::unique_ptr<RepeatingHand>> RepeatingHand::read(const std::string& hand) {
    const auto [name, pairs] =
        KeyedValues::file_and_pairs(std::string_view(hand).substr(std::string_view("rec:").size()));
    std::string file(name);
    if (file.empty())
        return usage_error("hand 'rec': no file; must be rec:FILE, a recording of a run",
                           {{Setting::hand}, {Setting::record}});
    TRY_ASSIGN(const auto given, KeyedValues::parse("hand 'rec'", pairs, keys));
    TRY_ASSIGN(auto recording, read_recording(file));
    const double metres = scale_of(recording.front());
    for (const RecordedPart& part : recording) {
        if (!(scale_of(part) > 0))
            return input_error(part.name +
                               ": does not say above 0 how far a device moves per scene unit (S)");
        if (scale_of(part) != metres)
            return input_error(part.name + ": a device moves otherwise per scene unit (S) than in part 1");
    }
    RecordedPart whole = in_one(std::move(recording));
    std::optional<double> deepest;
    if (given.given("depth")) deepest = given.number("depth") * 0.001;
    return std::unique_ptr<RepeatingHand>(
        new RepeatingHand(std::move(file), std::move(whole), metres, GoalWatch(metres, deepest)));
}

void RepeatingHand::goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    const auto& ticks = recording_.ticks;
    if (tick == 0) at_ = 0;
    while (at_ + 1 < ticks.size() && ticks[at_ + 1].time_ns <= tick * tick_ns) ++at_;
    std::copy(ticks[at_].goals.begin(), ticks[at_].goals.end(), goals.begin());
    watch_.look(probe, goals);
}

Result<void> ReplayCheck::consume(const TouchTick& tick) {
    if (difference_) return {};
    const RecordedPart::Tick& recorded = recording_.ticks[next_++];
    const std::string where = "tick " + std::to_string(tick.tick);
    if (recorded.frame_prev != tick.pair.prev.number || recorded.frame_next != tick.pair.next.number ||
        recorded.blend != tick.blend || recorded.epoch != tick.pair.epoch) {
        difference_ = where + ": " +
                      in_words(tick.pair.epoch, tick.pair.prev.number, tick.pair.next.number, tick.blend) +
                      ", recorded " +
                      in_words(recorded.epoch, recorded.frame_prev, recorded.frame_next, recorded.blend);
        return {};
    }
    for (std::size_t k = 0; k < tick.forces.size(); ++k) {
        if (same_bits(recorded.forces[k], tick.forces[k].force) &&
            recorded.guards[k] == tick.forces[k].reasons)
            continue;
        difference_ = where + ", finger " + std::to_string(k + 1) + ": force " +
                      to_text(tick.forces[k].force, tick.forces[k].reasons) + ", recorded " +
                      to_text(recorded.forces[k], recorded.guards[k]);
        return {};
    }
    return {};
}

ReplayCheck::Outcome ReplayCheck::outcome(const std::string& force_hash, bool has_other_frames) const {
    Outcome part{recording_.rules(), difference_, has_other_frames};
    const auto hash = recording_.facts.at("force_hash").get<std::string>();
    if (!part.difference && hash != force_hash)
        part.difference = "force_hash " + force_hash + ", recorded " + hash;
    return part;
}

Result<std::string> judge_replay(std::span<const ReplayCheck::Outcome> parts, const std::string& force_hash) {
    bool others = false;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const ReplayCheck::Outcome& part = parts[k];
        if (part.rules != force_rules)
            return input_error("replay is not comparable: made under rules " + std::to_string(part.rules) +
                               " of force, this program has rules " + std::to_string(force_rules) +
                               "; what was asked for is written, with its forces");
        others = others || part.has_other_frames;
        const std::string where = parts.size() > 1 ? "part " + std::to_string(k + 1) + ", " : "";
        if (part.difference)
            return Error{ErrorKind::check,
                         "replay differs first at " + where + *part.difference +
                             (part.has_other_frames ? "; the clip's frames are not the recorded ones" : "")};
    }
    const std::string all = parts.size() > 1 ? " in all " + std::to_string(parts.size()) + " parts" : "";
    return "replay: every force is as recorded, to the bit" + all + " (" + force_hash + ")\n" +
           (others ? "note: the clip's frames are not the recorded ones; they differ where no finger "
                     "felt it\n"
                   : "");
}

}  // namespace touchable
