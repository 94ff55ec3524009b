#include "player/session/interrupt.hpp"

#include <csignal>

#include "engine/stop_request.hpp"

namespace touchable {
namespace {

/// A signal that whoever started the program ignores stays ignored: nohup, a shell's background.
void catch_once(int signal) {
    struct sigaction inherited = {};
    sigaction(signal, nullptr, &inherited);
    if (inherited.sa_handler == SIG_IGN) return;
    struct sigaction action = {};
    action.sa_handler = [](int) { request_stop(); };
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_interrupts() {
    catch_once(SIGINT);
    catch_once(SIGTERM);
    catch_once(SIGHUP);             // the terminal is gone
    std::signal(SIGXFSZ, SIG_IGN);  // a file at its allowed size is an error of that write, told as any other
}

bool interrupted() {
    return stop_requested();
}

Error interrupted_error() {
    return {ErrorKind::interrupted, "interrupted; nothing half-written is left"};
}

}  // namespace touchable
