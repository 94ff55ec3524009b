#include "player/session/recording.hpp"

#include <bit>
#include <fstream>

#include "engine/scene/checked_json.hpp"

namespace touchable {

namespace {

// Layout: magic, version u32, fingers u32, ticks..., commands..., number of commands u64, facts (JSON), size
// of the facts u64, number of ticks u64, XXH64 of all before it u64. Format 1 has neither commands nor
// epochs.
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

/// Reads forward; the caller has made sure that there is enough.
class Bytes {
public:
    explicit Bytes(std::string_view bytes) : bytes_(bytes) {}
    std::uint64_t integer(int size) {
        std::uint64_t value = 0;
        for (int k = 0; k < size; ++k)
            value |= std::uint64_t{static_cast<std::uint8_t>(bytes_[at_++])} << (8 * k);
        return value;
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

RecordedTick read_tick(Bytes& bytes, std::uint64_t version, std::size_t fingers) {
    RecordedTick tick;
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
    PlaybackCommand command;
    command.tick = static_cast<std::int64_t>(bytes.integer(8));
    command.verb = static_cast<PlaybackVerb>(bytes.integer(4));
    command.first = static_cast<std::int64_t>(bytes.integer(8));
    command.second = static_cast<std::int64_t>(bytes.integer(8));
    return command;
}

/// Why ticks that can be read cannot be; empty where they can.
std::string fault_of(const std::vector<RecordedTick>& ticks) {
    if (ticks.empty()) return "has no ticks; there is nothing to replay";
    for (std::size_t k = 1; k < ticks.size(); ++k) {
        if (ticks[k].time_ns < ticks[k - 1].time_ns)
            return "tick " + std::to_string(k) + ": its time is before that of the tick before";
        if (ticks[k].epoch < ticks[k - 1].epoch)
            return "tick " + std::to_string(k) + ": its epoch is before that of the tick before";
    }
    return "";
}

Result<std::string> read_whole(const std::filesystem::path& file) {
    std::error_code failure;
    const auto size = std::filesystem::file_size(file, failure);  // fails for what is not a file
    std::string bytes(failure ? 0 : static_cast<std::size_t>(size), '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (failure || !in) return input_error("recording " + file.string() + ": cannot be read");
    return bytes;
}

}  // namespace

Result<Recording> read_recording(const std::filesystem::path& file) {
    const auto whole = read_whole(file);
    if (!whole.ok()) return whole.error();
    const std::string_view bytes = *whole;
    auto refuse = [&file](const std::string& why) {
        return input_error("recording " + file.string() + ": " + why);
    };

    if (bytes.size() < head_size || !bytes.starts_with(magic)) return refuse("is not a recording of a touch");
    Bytes head(bytes.substr(magic.size()));
    const std::uint64_t version = head.integer(4), fingers = head.integer(4);
    if (version > recording_format_version)
        return refuse("has format version " + std::to_string(version) + "; this program reads up to " +
                      std::to_string(recording_format_version));
    const std::string damaged = "is damaged or cut short; it cannot be replayed";
    if (version < 1 || fingers < 1 || fingers > most_fingers || bytes.size() < head_size + tail_size)
        return refuse(damaged);
    Bytes tail(bytes.substr(bytes.size() - tail_size));
    const std::uint64_t facts_size = tail.integer(8), ticks = tail.integer(8), hash = tail.integer(8);
    ByteHash found;
    found.add(bytes.data(), bytes.size() - 8);
    if (hash != found.value()) return refuse(damaged);
    const std::uint64_t tick_bytes = tick_size(version) + finger_size * fingers;
    const std::uint64_t room = bytes.size() - head_size - tail_size;
    const std::uint64_t count_size = version == 1 ? 0 : 8;
    if (facts_size > room || count_size > room - facts_size) return refuse(damaged);
    const std::size_t facts_at = bytes.size() - tail_size - facts_size;
    const std::uint64_t commands = version == 1 ? 0 : Bytes(bytes.substr(facts_at - count_size)).integer(8);
    const std::uint64_t left = room - facts_size - count_size;
    if (commands > left / command_size || ticks > left / tick_bytes ||
        ticks * tick_bytes + commands * command_size != left)
        return refuse(damaged);

    Recording recording;
    recording.fingers = static_cast<int>(fingers);
    Bytes body(bytes.substr(head_size));
    for (std::uint64_t k = 0; k < ticks; ++k)
        recording.ticks.push_back(read_tick(body, version, static_cast<std::size_t>(fingers)));
    for (std::uint64_t k = 0; k < commands; ++k) recording.playback.push_back(read_command(body));
    const std::string_view facts = bytes.substr(facts_at, facts_size);
    try {
        (void)checked_json::parse(facts);
    } catch (const checked_json::Refusal& reason) {
        return refuse(damaged + ": its facts, " + reason.message);
    }
    recording.facts = nlohmann::ordered_json::parse(facts, nullptr, false);
    if (!recording.facts.is_object()) return refuse(damaged);
    if (const std::string fault = fault_of(recording.ticks); !fault.empty()) return refuse(fault);
    if (auto valid = validate(recording.playback); !valid.ok()) return refuse(valid.error().message);
    // A loop is run through turn by turn.
    if (!recording.playback.empty() && recording.ticks.back().time_ns > latest_moment_ns)
        return refuse("its last tick is later than 1e6 s");
    return recording;
}

Result<void> RecordingFile::write(const std::string& bytes) {
    hash_.add(bytes.data(), bytes.size());
    return file_->write(bytes);
}

Result<std::unique_ptr<RecordingFile>> RecordingFile::create(const std::filesystem::path& file, int fingers,
                                                             Existing existing) {
    auto opened = OutputFile::create("--record", file, existing);
    if (!opened.ok()) return opened.error();
    std::unique_ptr<RecordingFile> out(new RecordingFile(std::move(*opened)));
    std::string head(magic);
    put(head, recording_format_version, 4);
    put(head, static_cast<std::uint64_t>(fingers), 4);
    if (auto written = out->write(head); !written.ok()) return written.error();
    return out;
}

Result<void> RecordingFile::take(const TouchTick& tick) {
    bytes_.clear();
    for (const std::int64_t value : {tick.time_ns, tick.pair.prev.number, tick.pair.next.number})
        put(bytes_, static_cast<std::uint64_t>(value), 8);
    put(bytes_, tick.blend);
    put(bytes_, tick.pair.epoch, 8);
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        put(bytes_, tick.goals[k]);
        put(bytes_, tick.forces[k].force);
        put(bytes_, tick.forces[k].reasons, 4);
    }
    ++ticks_;
    return write(bytes_);
}

Result<void> RecordingFile::finish(const nlohmann::ordered_json& facts,
                                   const std::vector<PlaybackCommand>& playback) {
    std::string tail;
    for (const PlaybackCommand& command : playback) {
        put(tail, static_cast<std::uint64_t>(command.tick), 8);
        put(tail, static_cast<std::uint64_t>(command.verb), 4);
        for (const std::int64_t value : {command.first, command.second})
            put(tail, static_cast<std::uint64_t>(value), 8);
    }
    put(tail, playback.size(), 8);
    // Names of files need not be UTF-8; JSON must.
    const std::string text = facts.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    const std::uint64_t facts_size = text.size();
    tail += text;
    put(tail, facts_size, 8);
    put(tail, ticks_, 8);
    if (auto written = write(tail); !written.ok()) return written;
    std::string hash;
    put(hash, hash_.value(), 8);
    if (auto written = write(hash); !written.ok()) return written;
    return file_->finish();
}

}  // namespace touchable
