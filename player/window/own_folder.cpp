#include "player/window/own_folder.hpp"

#include <cstdlib>
#include <string>

namespace touchable {

Result<std::filesystem::path> own_folder(const char* variable, const char* in_home) {
    const auto folder = [](const char* of) {
        const char* const value = std::getenv(of);
        return std::filesystem::path(value ? value : "");
    };
    // What is not absolute counts as not set.
    if (const auto stated = folder(variable); stated.is_absolute()) return stated / "touchable";
    if (const auto home = folder("HOME"); home.is_absolute()) return home / in_home / "touchable";
    return usage_error(std::string("neither HOME nor ") + variable + " says where to keep them");
}

}  // namespace touchable
