// SPDX-License-Identifier: Apache-2.0
// X server features beyond GLFW: touch screen fingers (XInput2), and keeping the display awake
// (MIT-SCREEN-SAVER). TOUCHABLE_HAS_X_TOUCH, TOUCHABLE_HAS_XSS: the libraries that the program is built with.

#include "player/window/x11_screen.hpp"

#include <poll.h>

#ifdef TOUCHABLE_HAS_X_TOUCH
#include <X11/Xlib.h>
#include <X11/extensions/XInput2.h>

#include <array>
#include <chrono>
#include <set>
#endif
#ifdef TOUCHABLE_HAS_XSS
#include <X11/extensions/scrnsaver.h>
#endif

namespace touchable {

#ifdef TOUCHABLE_HAS_X_TOUCH
namespace {

using Clock = std::chrono::steady_clock;

/// How long X may report its pointer after a finger was lifted, at most.
constexpr std::chrono::milliseconds pointer_lags(300);

struct Closed {
    void operator()(Display* display) const { XCloseDisplay(display); }
};
using Connection = std::unique_ptr<Display, Closed>;

Error no_touch(const char* why) {
    return {ErrorKind::device, why};
}

class X11TouchScreen final : public TouchScreen {
public:
    X11TouchScreen(Connection display, int opcode) : display_(std::move(display)), opcode_(opcode) {}
    ~X11TouchScreen() override {
        if (is_lost()) (void)display_.release();  // closing would talk to the server
    }

    std::vector<InputEvent> take() override {
        std::vector<InputEvent> events;
        while (!is_lost() && XPending(display_.get()) > 0) {
            XEvent event;
            XNextEvent(display_.get(), &event);
            XGenericEventCookie& cookie = event.xcookie;
            if (cookie.type != GenericEvent || cookie.extension != opcode_) continue;
            if (!XGetEventData(display_.get(), &cookie)) continue;
            add(cookie.evtype, *static_cast<const XIDeviceEvent*>(cookie.data), events);
            XFreeEventData(display_.get(), &cookie);
        }
        if (is_lost() && !down_.empty()) {
            down_.clear();
            events.push_back({.kind = InputEvent::Kind::left_window});
        }
        return events;
    }
    bool has_pointer() const override { return !down_.empty() || Clock::now() < pointer_until_; }
    int socket() const override { return is_lost() ? -1 : ConnectionNumber(display_.get()); }

private:
    bool is_lost() const { return is_hung_up(ConnectionNumber(display_.get())); }

    void add(int type, const XIDeviceEvent& event, std::vector<InputEvent>& events) {
        using Kind = InputEvent::Kind;
        // Each touch screen numbers its own fingers.
        const std::int64_t touch = (static_cast<std::int64_t>(event.sourceid) << 32) + event.detail;
        const bool begins = type == XI_TouchBegin, ends = type == XI_TouchEnd;
        if (begins && is_touch_screen(event.sourceid)) down_.insert(touch);
        if (!down_.contains(touch)) return;  // a touchpad's, or begun before
        if (ends) down_.erase(touch);
        pointer_until_ = Clock::now() + pointer_lags;
        events.push_back({.kind = begins ? Kind::touch_began
                                  : ends ? Kind::touch_ended
                                         : Kind::touch_moved,
                          .x = event.event_x,
                          .y = event.event_y,
                          .touch = touch,
                          .seconds = seconds_of(event.time)});
    }

    /// The server's milliseconds have 32 bits: they wrap every 50 days.
    double seconds_of(Time time) {
        const auto now = static_cast<std::uint32_t>(time);
        milliseconds_ += static_cast<std::int32_t>(now - std::exchange(last_, now));
        return static_cast<double>(milliseconds_) / 1000;
    }

    /// Direct touch: a finger's position is where it is seen, unlike a touchpad's.
    bool is_touch_screen(int device) {
        int count = 0;
        XIDeviceInfo* const infos = XIQueryDevice(display_.get(), device, &count);
        bool is = false;
        for (int k = 0; infos && k < count; ++k)
            for (int c = 0; c < infos[k].num_classes; ++c) {
                const auto* const any = infos[k].classes[c];
                is = is || (any->type == XITouchClass &&
                            reinterpret_cast<const XITouchClassInfo*>(any)->mode == XIDirectTouch);
            }
        if (infos) XIFreeDeviceInfo(infos);
        return is;
    }

    Connection display_;
    int opcode_;
    std::set<std::int64_t> down_;
    Clock::time_point pointer_until_{};
    std::uint32_t last_ = 0;
    std::int64_t milliseconds_ = 0;
};

}  // namespace

Result<std::unique_ptr<TouchScreen>> TouchScreen::open(unsigned long window) {
    Connection display(XOpenDisplay(nullptr));
    if (!display) return no_touch("no other connection to the display");
    // Xlib would end the program when this connection ends; GLFW's own already has such a handler.
    XSetIOErrorExitHandler(
        display.get(), [](Display*, void*) {}, nullptr);
    int opcode = 0, first_event = 0, first_error = 0, major = 2, minor = 2;
    if (!XQueryExtension(display.get(), "XInputExtension", &opcode, &first_event, &first_error) ||
        XIQueryVersion(display.get(), &major, &minor) != Success || major * 100 + minor < 202)
        return no_touch("the display knows no touches (XInput 2.2)");
    std::array<unsigned char, XIMaskLen(XI_LASTEVENT)> wanted{};
    for (const int type : {XI_TouchBegin, XI_TouchUpdate, XI_TouchEnd}) XISetMask(wanted.data(), type);
    XIEventMask mask{XIAllMasterDevices, static_cast<int>(wanted.size()), wanted.data()};
    XISelectEvents(display.get(), window, &mask, 1);
    XSync(display.get(), False);
    return std::unique_ptr<TouchScreen>(std::make_unique<X11TouchScreen>(std::move(display), opcode));
}
#else
Result<std::unique_ptr<TouchScreen>> TouchScreen::open(unsigned long) {
    return device_error("built without it (XInput2: libxi-dev)");
}
#endif

bool is_hung_up(int socket) {
    pollfd look{socket, POLLRDHUP, 0};
    return poll(&look, 1, 0) > 0 && (look.revents & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
}

#ifdef TOUCHABLE_HAS_XSS
void keep_screen_awake(void* display) {
    auto* const server = static_cast<Display*>(display);
    int first_event = 0, first_error = 0;
    if (XScreenSaverQueryExtension(server, &first_event, &first_error) == 0) return;
    XScreenSaverSuspend(server, True);
    XFlush(server);
}
#else
void keep_screen_awake(void*) {}
#endif

}  // namespace touchable
