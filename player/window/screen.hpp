#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

struct ScreenSize {
    int width = 0, height = 0;  ///< pixels; 0 while minimised
    double scale = 1;  ///< of words and lines: 2 on a display whose pixels are half as large as usual
};

/// Where pictures are shown and where input comes from. By the main thread alone.
class Screen {
public:
    virtual ~Screen() = default;
    /// Vulkan extensions that the device needs to be opened with (GpuOptions::window_extensions).
    virtual std::vector<std::string> extensions() const = 0;
    /// Pictures are drawn on this device from now on. Before the first `present`, and where the last device
    /// is lost.
    virtual Result<void> attach(std::shared_ptr<GpuDevice> device) = 0;
    /// Fails (ErrorKind::gpu) once there is nothing to show pictures on any more, for good.
    virtual Result<void> health() const = 0;
    virtual ScreenSize size() const = 0;
    /// Waits for input, at most so long, and gives what has come.
    virtual std::vector<InputEvent> poll(std::chrono::milliseconds longest) = 0;
    /// What becomes of the fingers on a touch screen, in a few words for a person; empty: there is none.
    virtual std::string touch_state() const = 0;
    /// Submits what draws `canvas`, which is then in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, waits for it, and
    /// shows it, stretched where the screen has another size by now.
    virtual Result<void> present(GpuCommands commands, const GpuImage& canvas) = 0;
    virtual void set_title(const std::string& title) = 0;
    virtual void set_fullscreen(bool on) = 0;
    /// As ScreenOptions has it, of a window that does not fill the screen.
    virtual void set_size(int width, int height) = 0;
    /// The pointer is hidden while a finger is drawn at its place.
    virtual void hide_pointer(bool hidden) = 0;
};

struct ScreenOptions {
    int width = 1280, height = 720;
    bool fullscreen = false;
    bool stays = false;  ///< it stays full screen while another window has the focus
    bool awake = false;  ///< the display neither blanks nor sleeps, as far as the system can be asked so
    /// Called with each key as it arrives, by a thread of the screen's own, however long the main thread
    /// draws; may change the event, which `poll` gives afterwards. Neither waits nor throws.
    std::function<void(InputEvent&)> at_once{};
};

/// A window of the system's. Refused (ErrorKind::gpu) where there is no display or no Vulkan to show by.
Result<std::unique_ptr<Screen>> open_glfw_screen(const ScreenOptions& options);

/// No window at all: pictures are drawn and not shown, and no input comes.
std::unique_ptr<Screen> make_headless_screen(const ScreenOptions& options);

/// An InputEvent's name of GLFW's key number `key`, on which `printed` stands (UTF-8, as GLFW names it; null:
/// nothing). Letters are those that are printed; where none of the Latin alphabet is, as on a Cyrillic
/// keyboard, that of the same place on an American one. So are digits, unless a sign that does something is
/// printed there. Empty: a key without a name, or a sign, which comes as a character (`name_of_sign`).
std::string name_of_key(int key, const char* printed);

/// Of a sign that was typed, whatever keys that takes; empty for all other characters (Unicode).
std::string name_of_sign(unsigned character);

}  // namespace touchable
