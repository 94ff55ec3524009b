#include "player/window/glfw_keys.hpp"

#include <cctype>
#include <cstring>

#include "player/window/window_command.hpp"

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

namespace touchable {
namespace {

/// Of a letter with an accent or the like, up to U+024F: UTF-8 of two bytes.
bool is_latin_letter(const char* printed) {
    const auto first = static_cast<unsigned char>(*printed);
    return first >= 0xC3 && first <= 0xC9;
}

}  // namespace

std::string name_of_key(int key, const char* printed) {
    constexpr struct {
        int key;
        const char* name;
    } functions[] = {
        {GLFW_KEY_SPACE, "space"},   {GLFW_KEY_LEFT, "left"},      {GLFW_KEY_RIGHT, "right"},
        {GLFW_KEY_UP, "up"},         {GLFW_KEY_DOWN, "down"},      {GLFW_KEY_HOME, "home"},
        {GLFW_KEY_END, "end"},       {GLFW_KEY_TAB, "tab"},        {GLFW_KEY_ESCAPE, "escape"},
        {GLFW_KEY_ENTER, "enter"},   {GLFW_KEY_KP_ENTER, "enter"}, {GLFW_KEY_BACKSPACE, "backspace"},
        {GLFW_KEY_DELETE, "delete"}, {GLFW_KEY_F1, "f1"},          {GLFW_KEY_F11, "f11"},
        {GLFW_KEY_F12, "f12"},       {GLFW_KEY_PAGE_UP, "pageup"}, {GLFW_KEY_PAGE_DOWN, "pagedown"}};
    for (const auto& function : functions)
        if (function.key == key) return function.name;
    const auto is_in = [](char c, char first, char last) { return c >= first && c <= last; };
    if (printed && std::strlen(printed) == 1 && (is_in(*printed, 'a', 'z') || is_in(*printed, '0', '9')))
        return printed;
    const bool is_bound_sign = printed && binding_of(printed, false, false);
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9 && !is_bound_sign)
        return std::string(1, static_cast<char>('0' + key - GLFW_KEY_0));
    const bool is_latin = printed && (is_in(*printed, '!', '~') || is_latin_letter(printed));
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z && !is_latin)
        return std::string(1, static_cast<char>('a' + key - GLFW_KEY_A));
    return "";
}

std::string name_of_sign(unsigned character) {
    constexpr unsigned arabic_question_mark = 0x61F;
    if (character == arabic_question_mark) return "?";
    const bool is_ascii = character > ' ' && character < 0x7F;
    if (!is_ascii || std::isalnum(static_cast<int>(character))) return "";
    return std::string(1, static_cast<char>(character));
}

}  // namespace touchable
