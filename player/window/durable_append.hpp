#pragma once

#include <string_view>

namespace touchable {

/// Appends all of `rows` to an open file and waits until they are safe on its disk; otherwise nothing of them
/// is in it. Returns 0, or what errno would be.
int append_durably(int out, std::string_view rows);

}  // namespace touchable
