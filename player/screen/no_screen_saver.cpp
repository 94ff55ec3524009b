#include "player/screen/screen_saver.hpp"

namespace touchable {

void keep_screen_awake(void*) {}

}  // namespace touchable
