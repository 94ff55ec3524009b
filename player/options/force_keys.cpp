#include "player/options/force_keys.hpp"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "engine/start_thread.hpp"

namespace touchable {

ForceKeys::ForceKeys(HandControl& control) : control_(control) {
    if (isatty(STDIN_FILENO) == 0) return;
    tcflush(STDIN_FILENO, TCIFLUSH);  // what was typed before meant something else
    [[maybe_unused]] const auto started =
        start_thread(thread_, "force-keys", "that reads keys", [this] { listen(); });
}

ForceKeys::~ForceKeys() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
}

void ForceKeys::listen() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (!over_) {
        if (poll(&input, 1, 50) <= 0) continue;
        char line[64];
        const auto typed = read(STDIN_FILENO, line, sizeof line);
        if (typed <= 0) return control_.ask_force(false);  // nobody can stop them any more
        if (line[0] == 'c' || line[0] == 'C')
            control_.recentre();
        else
            control_.ask_force(!control_.force_is_asked());
    }
}

}  // namespace touchable
