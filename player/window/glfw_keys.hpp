#pragma once

#include <string>

namespace touchable {

/// An InputEvent's name of GLFW's key number `key`, on which `printed` stands (UTF-8, as GLFW names it; null:
/// nothing). Letters are those that are printed; where none of the Latin alphabet is, as on a Cyrillic
/// keyboard, that of the same place on an American one. Digits likewise, unless a sign that does something is
/// printed there. Empty: a key without a name, or a sign, which comes as a character (`name_of_sign`).
std::string name_of_key(int key, const char* printed);

/// Of a sign that was typed, whatever keys that takes; empty for all other characters (Unicode).
std::string name_of_sign(unsigned character);

}  // namespace touchable
