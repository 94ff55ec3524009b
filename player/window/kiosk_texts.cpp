#include "player/window/kiosk_texts.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "engine/scene/checked_json.hpp"
#include "player/window/plain_line.hpp"

namespace touchable {
namespace {

constexpr struct {
    const char* member;
    std::string KioskTexts::*text;
} kiosk_texts[] = {{"invitation", &KioskTexts::invitation},
                   {"how_by_mouse", &KioskTexts::how_by_mouse},
                   {"how_by_touch_screen", &KioskTexts::how_by_touch_screen},
                   {"how_by_device", &KioskTexts::how_by_device},
                   {"force_is_off", &KioskTexts::force_is_off},
                   {"again_by_mouse", &KioskTexts::again_by_mouse},
                   {"again_by_touch_screen", &KioskTexts::again_by_touch_screen},
                   {"device_is_on", &KioskTexts::device_is_on},
                   {"device_is_off", &KioskTexts::device_is_off},
                   {"device_is_away", &KioskTexts::device_is_away},
                   {"device_has_no_force", &KioskTexts::device_has_no_force},
                   {"device_is_moved", &KioskTexts::device_is_moved},
                   {"come_out", &KioskTexts::come_out},
                   {"turn_back", &KioskTexts::turn_back},
                   {"touch", &KioskTexts::touch},
                   {"turn", &KioskTexts::turn},
                   {"pause", &KioskTexts::pause},
                   {"play", &KioskTexts::play},
                   {"colours", &KioskTexts::colours},
                   {"next", &KioskTexts::next},
                   {"limit", &KioskTexts::limit},
                   {"depth", &KioskTexts::depth},
                   {"stiffness", &KioskTexts::stiffness},
                   {"friction", &KioskTexts::friction},
                   {"height", &KioskTexts::height},
                   {"everywhere", &KioskTexts::everywhere},
                   {"study_begin", &KioskTexts::study_begin},
                   {"study_continue", &KioskTexts::study_continue},
                   {"study_wait", &KioskTexts::study_wait},
                   {"study_not_kept", &KioskTexts::study_not_kept}};

KioskTexts read_texts(const checked_json::Node& node) {
    std::vector<std::string> legal{"touchable_kiosk_texts", "language"};
    for (const auto& one : kiosk_texts) legal.emplace_back(one.member);
    node.allow_only(legal);
    if (node["touchable_kiosk_texts"].integer(1, 1'000'000) != 1)
        node["touchable_kiosk_texts"].refuse("1, the version that is read here");
    KioskTexts texts;
    texts.language = read_language(node["language"]);
    for (const auto& one : kiosk_texts)
        if (node.has(one.member)) texts.*one.text = read_plain_line(node[one.member]);
    return texts;
}

}  // namespace

std::string KioskTexts::all() const {
    std::string words;
    for (const auto& one : kiosk_texts) words += this->*one.text;
    return words;
}

const std::string& KioskTexts::how(TouchedBy by) const {
    if (by == TouchedBy::device) return how_by_device;
    return by == TouchedBy::mouse ? how_by_mouse : how_by_touch_screen;
}

const std::string& KioskTexts::again(TouchedBy by) const {
    return by == TouchedBy::touch_screen ? again_by_touch_screen : again_by_mouse;
}

const std::string& KioskTexts::of_device(HandState::What what) const {
    using What = HandState::What;
    switch (what) {
        case What::away:
            return device_is_away;
        case What::has_no_force:
            return device_has_no_force;
        case What::repositioned:
            return device_is_moved;
        case What::on:
            return device_is_on;
        default:
            return device_is_off;
    }
}

Result<KioskTexts> parse_kiosk_texts(std::string_view json, std::string_view where) {
    try {
        const checked_json::Json text = checked_json::parse(json, largest_kiosk_texts);
        return read_texts(checked_json::Node(text, ""));
    } catch (const checked_json::Refusal& reason) {
        return input_error(std::string(where) + ": " + reason.message);
    }
}

std::string own_language() {
    for (const char* const variable : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
        const char* const value = std::getenv(variable);
        if (!value || !*value) continue;
        const std::string locale = value;
        const std::string language = locale.substr(0, locale.find_first_of("_.@"));
        const bool is_one = (language.size() == 2 || language.size() == 3) &&
                            std::ranges::all_of(language, [](char c) { return c >= 'a' && c <= 'z'; });
        return is_one ? language : "en";
    }
    return "en";
}

}  // namespace touchable
