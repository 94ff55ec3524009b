#include "player/screen/x_connection.hpp"

#include <dlfcn.h>
#include <poll.h>

#include <atomic>

namespace touchable {
namespace {

std::atomic<bool> met_fault{false};  // of the connection, in the middle of a call
std::atomic<bool> met_no_window{false};

/// XErrorEvent, whose layout is part of Xlib's interface.
struct XRefusal {
    int type;
    void* display;
    unsigned long resource, serial;
    unsigned char error, request, minor_request;
};
constexpr unsigned char bad_window = 3, bad_drawable = 9;

/// Of a request that was refused: without it, Xlib ends the program.
int note_refusal(void*, XRefusal* refusal) {
    if (refusal->error == bad_window || refusal->error == bad_drawable) met_no_window = true;
    return 0;
}

/// GLFW for Wayland has none of these, and Xlib's headers are not needed for them.
template <class Function>
Function* function(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void XConnection::open() {
    using OnFault = int(void* display);
    using OnExit = void(void* display, void* data);
    using OnRefusal = int(void* display, XRefusal*);
    auto* const display_of_glfw = function<void*()>("glfwGetX11Display");
    auto* const socket_of = function<int(void*)>("XConnectionNumber");
    auto* const set_on_fault = function<OnFault*(OnFault*)>("XSetIOErrorHandler");
    auto* const set_on_exit = function<void(void*, OnExit*, void*)>("XSetIOErrorExitHandler");
    auto* const set_on_refusal = function<OnRefusal*(OnRefusal*)>("XSetErrorHandler");
    if (!display_of_glfw || !socket_of || !set_on_fault || !set_on_exit || !set_on_refusal) return;
    void* const display = display_of_glfw();
    if (!display) return;
    set_on_refusal(note_refusal);
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

bool XConnection::has_lost_window() const {
    return is_open() && met_no_window;
}

void XConnection::wait(std::chrono::milliseconds longest) const {
    pollfd look{socket_, POLLIN, 0};
    poll(&look, 1, static_cast<int>(longest.count()));
}

}  // namespace touchable
