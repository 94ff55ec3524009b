#include "player/commands/setting_words.hpp"

#include <algorithm>
#include <array>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {
namespace {

/// The text typed for a setting: an option, or another word of a command.
struct Spelling {
    Setting::Name setting;
    std::string option;
    std::string_view value{};  ///< as in --help; empty: no value, or stated by messages
};

/// Most settings' options have the setting's name.
Spelling spelling_of(const Hint& hint) {
    static const std::array irregular{Spelling{Setting::clip, "CLIP"},
                                      Spelling{Setting::device_rules, std::string(udev_rules_command)},
                                      Spelling{Setting::forces, "touch --forces"},
                                      Spelling{Setting::haptic_map, "--haptic"},
                                      Spelling{Setting::height_map, "--height"},
                                      Spelling{Setting::intrinsics, "--intrinsics", "FX,FY,CX,CY"},
                                      Spelling{Setting::playback, "--play"},
                                      Spelling{Setting::record, "touch --record"},
                                      Spelling{Setting::scene_file, "--scene", "FILE"},
                                      Spelling{Setting::stiffness_rise, "--stiffness-slew"}};
    const auto* const found = std::ranges::find(irregular, hint.setting, &Spelling::setting);
    if (found != irregular.end()) return *found;
    const SourceSetting* const of_source = source_setting(hint.setting);
    return {hint.setting, "--" + with_dashes(hint.setting), of_source ? of_source->form : ""};
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
        const std::string option = spelling_of(hint).option;
        if (knows && option.starts_with("--") && !knows(option)) continue;
        if (&hint == &error.hints.front() && begins_with_name(text, option))
            text.insert(0, "--");
        else
            behind += (behind.empty() ? "" : ", ") + typed(option, hint.value);
    }
    if (behind.empty()) return text;
    if (!text.ends_with(')')) return text + " (" + behind + ')';
    text.back() = ';';  // avoids two pairs of brackets
    return text + ' ' + behind + ')';
}

std::string remark_with_options(const Remark& remark) {
    if (remark.hints.empty() && (!remark.is_guess || !remark.otherwise.empty()))
        return remark_in_words(remark);
    std::string options;
    const Hints anything{{Setting::scene_file}};  // the fallback if no option exists
    for (const Hint& hint : remark.hints.empty() ? anything : remark.hints) {
        const Spelling spelling = spelling_of(hint);
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
