#include "engine/base/same_bits.hpp"
#include "player/run/run_files.hpp"
#include "player/run/surface_feed.hpp"
#include "player/session/run_record.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// A recording of one part with a hash that is right, so that damage is not found by it alone.
std::string with_right_hash(std::string bytes) {
    constexpr std::size_t size = 8;
    if (bytes.size() < size) return bytes;
    ByteHash hash;
    hash.add(bytes.data(), bytes.size() - size);
    for (std::size_t k = 0; k < size; ++k)
        bytes[bytes.size() - size + k] = static_cast<char>(hash.value() >> (8 * k));
    return bytes;
}

bool parse_recording(std::string_view bytes) {
    const auto recording = read_recording(file_of(bytes, "touch.rec"));
    if (!is_taken(recording)) return false;
    require(!recording->empty(), "a recording without a part");
    for (const RecordedPart& part : *recording) {
        require(part.fingers > 0 && !part.ticks.empty(), "a part without fingers or ticks");
        for (const RecordedPart::Tick& tick : part.ticks)
            require(tick.goals.size() == static_cast<std::size_t>(part.fingers) &&
                        tick.forces.size() == tick.goals.size() && tick.guards.size() == tick.goals.size(),
                    "a tick has not one of each for a finger");
        TouchSetup setup;
        const auto scene = read_recorded_facts(part.facts, part.name, setup);
        if (!is_taken(scene)) return false;
        require(part.rules() >= 1, "rules of force below 1");
        try {
            (void)built_frames(part.facts);
        } catch (const std::out_of_range&) {
            require(false, "frames are refused that the facts were taken with");
        }
    }
    return true;
}

bool parse_recording_and_mended(std::string_view bytes) {
    (void)parse_recording(with_right_hash(std::string(bytes)));
    return parse_recording(bytes);
}

bool parse_playback_script(std::string_view bytes) {
    const auto commands = parse_playback(bytes, "script");
    if (!is_taken(commands)) return false;
    require(bool(validate(*commands)), "commands that were read will not do");
    (void)in_words(*commands);
    return true;
}

const Registered recording_target{
    {.name = "recording", .parse = parse_recording_and_mended, .cuts_are_refused = true}};
const Registered playback_target{{.name = "playback", .parse = parse_playback_script, .most_bytes = 1024}};

}  // namespace
}  // namespace touchable::fuzz
