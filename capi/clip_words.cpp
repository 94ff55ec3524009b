#include "capi/clip_words.hpp"

#include <string_view>

namespace touchable::capi {
namespace {

/// What a program sets for it in touch_clip_settings; empty: nothing there.
std::string_view members_of(Setting setting) {
    switch (setting) {
        case Setting::depth_unit:
            return "metres_per_code";
        case Setting::field_of_view:
            return "fov_degrees";
        case Setting::intrinsics:
            return "fx_px and fy_px";
        case Setting::preset:
            return "preset";
        case Setting::scene_file:
            return "scene_file";
        default:
            return {};
    }
}

std::string members_of(const Hints& hints) {
    std::string members;
    for (const Hint& hint : hints) {
        const std::string_view member = members_of(hint.setting);
        if (!member.empty()) members.append(members.empty() ? "" : " or ").append(member);
    }
    return members;
}

}  // namespace

Error with_members(const Error& error) {
    const std::string members = members_of(error.hints);
    return members.empty() ? error : Error{error.kind, error.message + " (" + members + ')'};
}

std::string note_with_members(const Remark& remark) {
    const std::string members = members_of(remark.hints);
    if (members.empty()) return remark_in_words(remark);
    Remark with = remark;
    with.otherwise =
        remark.otherwise.empty() ? members + " says otherwise" : remark.otherwise + ": " + members;
    return remark_in_words(with);
}

}  // namespace touchable::capi
