#pragma once

#include <string>

namespace touchable {

/// What InputEvent calls a key of GLFW's: by `printed`, what the keyboard's layout has on it (or null), or by
/// its function; empty where nobody asks for it.
std::string name_of_key(int key, const char* printed);

}  // namespace touchable
