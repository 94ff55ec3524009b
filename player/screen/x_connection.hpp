#pragma once

#include <chrono>

namespace touchable {

/// GLFW's connection to an X server. Left alone, Xlib ends the program where the server goes away, or another
/// program destroys the window; with this, its calls do nothing from then on. Nothing of it does anything
/// where GLFW speaks to something else.
class XConnection {
public:
    /// After glfwInit.
    void open();
    bool is_open() const { return socket_ >= 0; }
    /// The server has gone away. Xlib, and so GLFW, then knows nothing of use any more.
    bool is_lost() const;
    /// Another program has destroyed the window: an X server has refused something for that reason.
    bool has_lost_window() const;
    /// Until there is something to be read, but no longer than that.
    void wait(std::chrono::milliseconds longest) const;

private:
    int socket_ = -1;
};

}  // namespace touchable
