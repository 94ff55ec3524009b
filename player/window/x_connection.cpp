#include "player/window/x_connection.hpp"

#include <dlfcn.h>
#include <poll.h>

#include <atomic>

namespace touchable {
namespace {

std::atomic<bool> met_fault{false};  // of the connection, in the middle of a call

/// GLFW for Wayland has none of these, and Xlib's headers are not needed for them.
template <class Function>
Function* function(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void XConnection::open() {
    using OnFault = int(void* display);
    using OnExit = void(void* display, void* data);
    auto* const display_of_glfw = function<void*()>("glfwGetX11Display");
    auto* const socket_of = function<int(void*)>("XConnectionNumber");
    auto* const set_on_fault = function<OnFault*(OnFault*)>("XSetIOErrorHandler");
    auto* const set_on_exit = function<void(void*, OnExit*, void*)>("XSetIOErrorExitHandler");
    if (!display_of_glfw || !socket_of || !set_on_fault || !set_on_exit) return;
    void* const display = display_of_glfw();
    if (!display) return;
    set_on_fault([](void*) {
        met_fault = true;
        return 0;
    });
    set_on_exit(
        display, [](void*, void*) {}, nullptr);
    socket_ = socket_of(display);
}

bool XConnection::is_lost() const {
    if (!is_open()) return false;
    if (met_fault) return true;
    pollfd look{socket_, POLLRDHUP, 0};
    return poll(&look, 1, 0) > 0 && (look.revents & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
}

void XConnection::wait(std::chrono::milliseconds longest) const {
    pollfd look{socket_, POLLIN, 0};
    poll(&look, 1, static_cast<int>(longest.count()));
}

}  // namespace touchable
