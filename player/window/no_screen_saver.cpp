#include "player/window/screen_saver.hpp"

namespace touchable {

void keep_screen_awake(void*) {}

}  // namespace touchable
