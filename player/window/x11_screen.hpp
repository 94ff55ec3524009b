#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

/// The fingers on touch screens over an X window. GLFW has no word for them: it tells of the first alone, as
/// X's pointer. So this listens by XInput2, on a connection of its own. By the thread that has GLFW.
class TouchScreen {
public:
    /// Over that window of X's (GLFW's), after it was made. Errors (ErrorKind::device) are a few words: the
    /// server knows no touches, or the program was built without libxi-dev.
    static Result<std::unique_ptr<TouchScreen>> open(unsigned long window);
    virtual ~TouchScreen() = default;
    /// What has come: touches, places in pixels of the window; and that all are lifted, where the connection
    /// is lost. Waits for nothing.
    virtual std::vector<InputEvent> take() = 0;
    /// Whether a finger is down, or was a moment ago. X's pointer then is where the first of them is: it is
    /// no mouse.
    virtual bool has_pointer() const = 0;
    /// What poll(2) tells of that something has come; -1: nothing will.
    virtual int socket() const = 0;
};

/// Until that connection closes, its X server neither blanks the screen nor lets it sleep. Does nothing where
/// the server cannot be asked so (its extension MIT-SCREEN-SAVER), or the program was built without libXss.
/// `display`: Xlib's Display*.
void keep_screen_awake(void* display);

}  // namespace touchable
