#include "player/window/glfw_keys.hpp"

#include <cstring>

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

namespace touchable {

std::string name_of_key(int key, const char* printed) {
    constexpr struct {
        int key;
        const char* name;
    } functions[] = {{GLFW_KEY_SPACE, "space"},
                     {GLFW_KEY_LEFT, "left"},
                     {GLFW_KEY_RIGHT, "right"},
                     {GLFW_KEY_UP, "up"},
                     {GLFW_KEY_DOWN, "down"},
                     {GLFW_KEY_HOME, "home"},
                     {GLFW_KEY_END, "end"},
                     {GLFW_KEY_TAB, "tab"},
                     {GLFW_KEY_ESCAPE, "escape"},
                     {GLFW_KEY_ENTER, "enter"},
                     {GLFW_KEY_BACKSPACE, "backspace"},
                     {GLFW_KEY_DELETE, "delete"},
                     {GLFW_KEY_F1, "f1"},
                     {GLFW_KEY_F11, "f11"},
                     {GLFW_KEY_F12, "f12"},
                     {GLFW_KEY_PAGE_UP, "pageup"},
                     {GLFW_KEY_PAGE_DOWN, "pagedown"}};
    for (const auto& function : functions)
        if (function.key == key) return function.name;
    return printed && std::strlen(printed) == 1 ? printed : "";
}

}  // namespace touchable
