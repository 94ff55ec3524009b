// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "player/view/pointer.hpp"

namespace touchable {

/// Touch screen fingers over an X window. GLFW reports only the first one, as X's pointer, so this class uses
/// XInput2, on its own connection. GLFW's thread only.
class TouchScreen {
public:
    /// Opens over an existing X window (GLFW's). Errors (ErrorKind::device) are a few words: the server has
    /// no touch support, or the program was built without libxi-dev.
    static Result<std::unique_ptr<TouchScreen>> open(unsigned long window);
    virtual ~TouchScreen() = default;
    /// New events: touches, in pixels of the window; and `left_window` if the connection is lost, which lifts
    /// all. Does not wait.
    virtual std::vector<InputEvent> take() = 0;
    /// Whether a finger is down, or was a moment ago. X's pointer is then the first finger, not a mouse.
    virtual bool has_pointer() const = 0;
    /// The socket for poll(2); -1: no more events.
    virtual int socket() const = 0;
};

/// Whether the connection of this socket is lost: on one, Xlib would end the program, or wait for ever.
bool is_hung_up(int socket);

/// Keeps the screen from blanking and sleeping until that connection closes. Does nothing if the server does
/// not support it (extension MIT-SCREEN-SAVER), or the program was built without libXss. `display`: Xlib's
/// Display*.
void keep_screen_awake(void* display);

}  // namespace touchable
