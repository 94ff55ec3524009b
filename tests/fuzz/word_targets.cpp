// Words of a person: options, scripts of the window and its settings, and text as messages quote it.
#include <cmath>

#include "engine/base/words.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/draw/view.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_command.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// One text, read as every option that has words of its own.
bool parse_options(std::string_view bytes) {
    const std::string words(bytes);
    int taken = 0;
    if (const auto size = read_pixel_size("--size", words, 1, 8192); is_taken(size, Quotes::typed)) {
        require(size->width >= 1 && size->width <= 8192 && size->height >= 1 && size->height <= 8192,
                "a size beyond what was allowed");
        ++taken;
    }
    if (const auto number = read_whole_number<std::int64_t>("--n", words, -5, 5'000'000'000);
        is_taken(number, Quotes::typed)) {
        require(*number >= -5 && *number <= 5'000'000'000, "a number beyond what was allowed");
        ++taken;
    }
    if (const auto camera = read_live_camera(words); is_taken(camera, Quotes::typed)) {
        require(!camera->delivery.rate || camera->delivery.rate->num > 0, "a rate is not above 0");
        ++taken;
    }
    if (const auto view = parse_viewpoint(words); is_taken(view, Quotes::typed)) {
        require(std::abs(view->azimuth) <= 180 && std::abs(view->elevation) <= 89, "an impossible view");
        ++taken;
    }
    // A path that is there is read: another target's.
    CameraTyped typed;
    typed.intrinsics = words.substr(0, words.find_first_of("/."));
    taken += is_taken(read_camera(typed), Quotes::typed) ? 1 : 0;
    taken += is_taken(read_filters(words), Quotes::typed) ? 1 : 0;
    for (const FilterSetting& setting : filter_settings()) {
        FilterSettings filter;
        taken += setting.read(words, filter) ? 1 : 0;
    }
    return taken > 0;
}

bool parse_window_script(std::string_view bytes) {
    const auto inputs = read_window_script(file_of(bytes, "window.script"));
    if (!is_taken(inputs, Quotes::typed)) return false;
    double before = 0;
    for (const ScriptedInput& input : *inputs) {
        require(input.seconds >= before && input.seconds <= 1e6, "a moment is before the one above");
        before = input.seconds;
    }
    return true;
}

/// What is kept is found again.
bool parse_settings(std::string_view bytes) {
    const auto file = file_of(bytes, "play.json");
    const SettingsFile kept(file);
    for (const std::string& aside : {file.string() + ".broken"}) std::filesystem::remove(aside);
    const auto written = file_of("{}", "again.json");
    require(bool(SettingsFile(written).write(kept.read())), "settings cannot be written");
    const SettingsFile again(written);
    require(again.message().empty(), "settings that were written are not right: " + again.message());
    require(again.read() == kept.read(), "settings are others when they are read again");
    return kept.message().empty();
}

bool parse_printable(std::string_view bytes) {
    constexpr std::size_t most = 40;
    for (const std::string& quoted : {printable(bytes, most), in_quotes(bytes)}) {
        for (const char c : quoted)
            require(static_cast<unsigned char>(c) >= 0x20 && c != '\x7f', "a control character is quoted");
        require(quoted.size() <= 4 * 80 + 5, "a quotation is long");
    }
    return true;
}

const Registered options_target{{.name = "options", .parse = parse_options, .most_bytes = 128}};
const Registered window_script_target{
    {.name = "window_script", .parse = parse_window_script, .most_bytes = 1024}};
const Registered settings_target{{.name = "settings", .parse = parse_settings, .most_bytes = 1024}};
const Registered printable_target{{.name = "printable", .parse = parse_printable, .most_bytes = 256}};

}  // namespace
}  // namespace touchable::fuzz
