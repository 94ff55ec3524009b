#include "player/commands/setting_words.hpp"

#include "device/drivers/device_catalog.hpp"

namespace touchable {
namespace {

/// What a person types for a setting: an option, or another word of a command.
struct Spelling {
    Setting setting;
    std::string_view option;
    std::string_view value{};  ///< as --help has it; empty: it has none, or messages say it
};

constexpr std::array spellings{
    Spelling{Setting::builder, "--builder"},
    Spelling{Setting::camera, "--camera"},
    Spelling{Setting::clip, "CLIP"},
    Spelling{Setting::damping, "--damping"},
    Spelling{Setting::depth_unit, "--depth-unit", "METRES"},
    Spelling{Setting::device, "--device"},
    Spelling{Setting::device_rules, udev_rules_command},
    Spelling{Setting::field_of_view, "--fov", "DEGREES"},
    Spelling{Setting::fingers, "--fingers"},
    Spelling{Setting::forces, "touch --forces"},
    Spelling{Setting::gpu, "--gpu"},
    Spelling{Setting::hand, "--hand"},
    Spelling{Setting::haptic_map, "--haptic"},
    Spelling{Setting::headless, "--headless"},
    Spelling{Setting::height_map, "--height"},
    Spelling{Setting::interpolation, "--interpolation"},
    Spelling{Setting::intrinsics, "--intrinsics", "FX,FY,CX,CY"},
    Spelling{Setting::live, "--live"},
    Spelling{Setting::loop, "--loop"},
    Spelling{Setting::max_force, "--max-force"},
    Spelling{Setting::max_stiffness, "--max-stiffness"},
    Spelling{Setting::painter, "--painter"},
    Spelling{Setting::passivity, "--passivity"},
    Spelling{Setting::playback, "--play"},
    Spelling{Setting::preset, "--preset", "NAME"},
    Spelling{Setting::rate, "--rate"},
    Spelling{Setting::record, "touch --record"},
    Spelling{Setting::scene_file, "--scene", "FILE"},
    Spelling{Setting::script, "--script"},
    Spelling{Setting::seconds, "--seconds"},
    Spelling{Setting::stale_after, "--stale-after"},
    Spelling{Setting::start, "--start"},
    Spelling{Setting::start_buried, "--start-buried"},
    Spelling{Setting::stiffness_rise, "--stiffness-slew"},
    Spelling{Setting::stribeck, "--stribeck"},
    Spelling{Setting::temporal, "--temporal"},
    Spelling{Setting::view, "--view"},
};

constexpr bool each_has_its_place() {
    for (std::size_t n = 0; n < spellings.size(); ++n)
        if (spellings[n].setting != static_cast<Setting>(n)) return false;
    return spellings.size() == setting_count;
}
static_assert(each_has_its_place());

const Spelling& spelling_of(const Hint& hint) {
    return spellings[static_cast<std::size_t>(hint.setting)];
}

std::string typed(std::string_view option, std::string_view value) {
    return std::string(option) + (value.empty() ? "" : ' ' + std::string(value));
}

/// "--damping" for "damping must be ...".
bool begins_with_name(std::string_view message, std::string_view option) {
    if (!option.starts_with("--")) return false;
    option.remove_prefix(2);
    return message.starts_with(option) && message.substr(option.size()).starts_with(' ');
}

}  // namespace

std::string message_with_options(const Error& error, const KnowsOption& knows) {
    std::string text = error.message, behind;
    for (const Hint& hint : error.hints) {
        const std::string_view option = spelling_of(hint).option;
        if (knows && option.starts_with("--") && !knows(std::string(option))) continue;
        if (&hint == &error.hints.front() && begins_with_name(text, option))
            text.insert(0, "--");
        else
            behind += (behind.empty() ? "" : ", ") + typed(option, hint.value);
    }
    if (behind.empty()) return text;
    if (!text.ends_with(')')) return text + " (" + behind + ')';
    text.back() = ';';  // not one bracket behind the other
    return text + ' ' + behind + ')';
}

std::string remark_with_options(const Remark& remark) {
    if (remark.hints.empty() && (!remark.is_guess || !remark.otherwise.empty()))
        return remark_in_words(remark);
    std::string options;
    const Hints anything{{Setting::scene_file}};  // says what no other option does
    for (const Hint& hint : remark.hints.empty() ? anything : remark.hints) {
        const Spelling& spelling = spelling_of(hint);
        options += options.empty() ? "" : " or ";
        options += typed(spelling.option, hint.value.empty() ? spelling.value : hint.value);
    }
    Remark with_options = remark;
    with_options.otherwise =
        remark.otherwise.empty() ? options + " says otherwise" : remark.otherwise + ": " + options;
    return remark_in_words(with_options);
}

std::vector<std::string> remarks_with_options(const std::vector<Remark>& remarks) {
    std::vector<std::string> words;
    for (const Remark& remark : remarks) words.push_back(remark_with_options(remark));
    return words;
}

std::string typed_options(const Hints& hints) {
    std::string words;
    for (const Hint& hint : hints) words += ' ' + typed(spelling_of(hint).option, hint.value);
    return words;
}

}  // namespace touchable
