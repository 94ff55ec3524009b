// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/view/pointer.hpp"

namespace touchable {

struct ScreenSize {
    int width = 0, height = 0;  ///< pixels; 0 while minimised
    double scale = 1;           ///< of text and lines: 2 on a display with pixels half the usual size
};

/// Displays pictures and delivers input. Defaults are those of a screen without a display. Main thread only.
class Screen {
public:
    virtual ~Screen() = default;
    /// Vulkan extensions that the device must be opened with (GpuOptions::window_extensions).
    virtual std::vector<std::string> extensions() const { return {}; }
    /// Sets the device that draws the pictures. Call before the first `present`, and after the last device is
    /// lost.
    virtual Result<void> attach(std::shared_ptr<GpuDevice> /*device*/) { return {}; }
    /// Fails (ErrorKind::gpu) once pictures can no longer be shown, permanently.
    virtual Result<void> health() const { return {}; }
    virtual ScreenSize size() const = 0;
    /// Waits for input, for `longest` at most, and returns the events.
    virtual std::vector<InputEvent> poll(std::chrono::milliseconds longest) = 0;
    /// How touch screen input is handled, in a few words for the user; empty: no touch screen.
    virtual std::string touch_state() const { return {}; }
    /// Submits the commands that draw `canvas` (then in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL), waits for
    /// them, and shows it, stretched if the screen's size has changed.
    virtual Result<void> present(GpuCommands commands, const GpuImage& canvas) = 0;
    virtual void set_title(const std::string& /*title*/) {}
    virtual void set_fullscreen(bool /*on*/) {}
    /// In ScreenOptions' units, for a window that is not full screen.
    virtual void set_size(int width, int height) = 0;
    virtual void set_clipboard(const std::string& /*text*/) {}
    /// Hides the pointer while a finger is drawn at its place.
    virtual void hide_pointer(bool /*hidden*/) {}
};

struct ScreenOptions {
    int width = 1280, height = 720;
    bool fullscreen = false;
    bool stays = false;  ///< stays full screen while another window has the focus
    bool awake = false;  ///< asks the system to keep the display from blanking or sleeping
    /// Called with each key on arrival, on a thread of the screen's own, independently of the main thread's
    /// drawing; may change the event before `poll` returns it. Neither waits nor throws.
    std::function<void(InputEvent&)> at_once{};
};

/// A system window. Fails (ErrorKind::gpu) without a display or a Vulkan that can present.
Result<std::unique_ptr<Screen>> open_glfw_screen(const ScreenOptions& options);

/// No window: pictures are drawn but not shown, and no input comes.
std::unique_ptr<Screen> make_headless_screen(const ScreenOptions& options);

/// The InputEvent name of GLFW's key number `key`, labelled `printed` (UTF-8, from GLFW; null: no label).
/// Letters are those printed; without a Latin letter, as on a Cyrillic keyboard, the American keyboard's at
/// the same place. The same holds for digits, unless a sign with a command is printed there. Empty: a key
/// without a name, or a sign, which comes as a character (`name_of_sign`).
std::string name_of_key(int key, const char* printed);

/// The name of a typed sign, however it was typed; empty for all other characters (Unicode).
std::string name_of_sign(unsigned character);

}  // namespace touchable
