// SPDX-License-Identifier: Apache-2.0
// A system window with GLFW: pictures presented with Vulkan, keys, mouse and touch screen as events, and
// handling of a lost X server.

#include <dlfcn.h>
#include <poll.h>
#include <vulkan/vulkan.h>

#include <array>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <future>
#include <new>
#include <tuple>

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/window/command_table.hpp"
#include "player/window/screen.hpp"
#include "player/window/x11_screen.hpp"

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

// Of libxcb, which libX11 loads: its header need not be there.
struct xcb_connection_t;
using xcb_window_t = std::uint32_t;
using xcb_visualid_t = std::uint32_t;
#include <vulkan/vulkan_xcb.h>

namespace touchable {
namespace {

/// Looked up at run time: GLFW for Wayland lacks these, and Xlib's headers are not needed.
template <class Function>
Function* function(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// A window's Vulkan surface. Must outlive every swapchain on it.
class WindowSurface : NonCopyable {
public:
    /// `x_window`: GLFW's window of an X server; 0: there is none. Vulkan gets a connection of its own to
    /// that: where two threads wait for answers on one and the server goes away, libxcb (1.15) hangs in both.
    static Result<std::unique_ptr<WindowSurface>> create(std::shared_ptr<VulkanDevice> vulkan,
                                                         GLFWwindow* window, unsigned long x_window) {
        std::unique_ptr<WindowSurface> made(new WindowSurface(std::move(vulkan)));
        const VkInstance instance = made->vulkan_->instance_handle();
        const auto create_surface = reinterpret_cast<PFN_vkCreateXcbSurfaceKHR>(
            vkGetInstanceProcAddr(instance, "vkCreateXcbSurfaceKHR"));
        if (x_window != 0 && create_surface) made->connect();
        if (!made->connection_) {
            TRY(made->vulkan_->checked("glfwCreateWindowSurface",
                                       glfwCreateWindowSurface(instance, window, nullptr, &made->surface_)));
            return made;
        }
        VkXcbSurfaceCreateInfoKHR info{};
        info.sType = VK_STRUCTURE_TYPE_XCB_SURFACE_CREATE_INFO_KHR;
        info.connection = made->connection_;
        info.window = static_cast<xcb_window_t>(x_window);
        TRY(made->vulkan_->checked("vkCreateXcbSurfaceKHR",
                                   create_surface(instance, &info, nullptr, &made->surface_)));
        return made;
    }
    ~WindowSurface() {
        vkDestroySurfaceKHR(vulkan_->instance_handle(), surface_, nullptr);
        if (connection_) function<void(xcb_connection_t*)>("xcb_disconnect")(connection_);
    }
    VkSurfaceKHR handle() const { return surface_; }

private:
    explicit WindowSurface(std::shared_ptr<VulkanDevice> vulkan) : vulkan_(std::move(vulkan)) {}
    /// A server may refuse another connection: then GLFW's serves.
    void connect() {
        auto* const open = function<xcb_connection_t*(const char*, int*)>("xcb_connect");
        auto* const has_failed = function<int(xcb_connection_t*)>("xcb_connection_has_error");
        if (!open || !has_failed) return;
        xcb_connection_t* const opened = open(nullptr, nullptr);
        if (has_failed(opened) == 0)
            connection_ = opened;
        else
            function<void(xcb_connection_t*)>("xcb_disconnect")(opened);
    }

    std::shared_ptr<VulkanDevice> vulkan_;
    xcb_connection_t* connection_ = nullptr;  // null: GLFW's
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
};

/// A window's swapchain. `present` waits for the drawing to complete, so that its inputs need not be kept
/// longer. It does not wait for a hanging GPU, but leaks what that may still use. A lost surface counts as a
/// lost GPU: both must be reopened.
class Swapchain : NonCopyable {
public:
    /// ErrorKind::gpu if the device cannot present to this surface.
    static Result<std::unique_ptr<Swapchain>> create(std::shared_ptr<GpuDevice> device,
                                                     std::unique_ptr<WindowSurface> surface) {
        std::unique_ptr<Swapchain> made(new Swapchain(std::move(device), std::move(surface)));
        TRY(made->choose());
        return made;
    }
    ~Swapchain() {
        if (acquiring_ || !device_->comes_to_rest()) {
            leave_for_good(device_->vulkan());
            leave_for_good(std::shared_ptr<WindowSurface>(std::move(surface_)));
            return;
        }
        destroy_chain();
        if (acquired_) vkDestroyFence(device_->vulkan()->device, acquired_, nullptr);
    }

    /// Screen::present; `wanted`: the window's size in pixels, which the surface may override. Nothing is
    /// shown while it is empty.
    Result<void> present(GpuCommands commands, const GpuImage& canvas, VkExtent2D wanted) {
        std::uint32_t index = 0;
        bool shown = false;
        if (chain_ && !outdated_) TRY(assign(shown, acquire(index)));
        if (!shown) {
            TRY_ASSIGN(shown, make(wanted));
            if (shown) TRY(assign(shown, acquire(index)));
        }
        if (shown) record_copy(commands, canvas, images_[index]);
        TRY(std::move(commands).run());
        if (!shown) return {};
        VulkanDevice& gpu = *device_->vulkan();
        auto info = vulkan_struct<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
        info.swapchainCount = 1;
        info.pSwapchains = &chain_;
        info.pImageIndices = &index;
        VkResult result;
        {
            const std::lock_guard lock(gpu.queue_mutex);
            result = vkQueuePresentKHR(gpu.queue, &info);
        }
        outdated_ = outdated_ || result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
        if (result != VK_SUCCESS && !outdated_) return failed("vkQueuePresentKHR", result);
        return {};
    }

    /// Gives up the GPU: a thread may wait for the display in `present`, and hold the GPU's queue.
    void leave() { device_->lose(); }

private:
    Swapchain(std::shared_ptr<GpuDevice> device, std::unique_ptr<WindowSurface> surface)
        : device_(std::move(device)), surface_(std::move(surface)) {}
    Result<void> choose() {
        VulkanDevice& gpu = *device_->vulkan();
        VkBool32 shows = VK_FALSE;
        const VkResult asked =
            vkGetPhysicalDeviceSurfaceSupportKHR(gpu.physical, gpu.queue_family, surface_->handle(), &shows);
        if (asked != VK_SUCCESS || !shows)
            return gpu_error(gpu.facts.name + " cannot show pictures in this window; another GPU may",
                             {{Setting::gpu, "NAME"}});
        const auto formats = vulkan_list<VkSurfaceFormatKHR>(vkGetPhysicalDeviceSurfaceFormatsKHR,
                                                             gpu.physical, surface_->handle());
        // The canvas holds final (sRGB) values: an sRGB format would brighten it, so it is the last resort.
        const auto plain = std::ranges::find_if(formats, [](const VkSurfaceFormatKHR& format) {
            return format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM;
        });
        if (formats.empty()) return gpu_error(gpu.facts.name + " has no format for this window");
        format_ = plain == formats.end() ? formats.front() : *plain;
        const auto modes = vulkan_list<VkPresentModeKHR>(vkGetPhysicalDeviceSurfacePresentModesKHR,
                                                         gpu.physical, surface_->handle());
        // The player paces itself: waiting for the screen here would only add delay.
        if (std::ranges::find(modes, VK_PRESENT_MODE_MAILBOX_KHR) != modes.end())
            mode_ = VK_PRESENT_MODE_MAILBOX_KHR;
        auto fence = vulkan_struct<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
        return gpu.checked("vkCreateFence", vkCreateFence(gpu.device, &fence, nullptr, &acquired_));
    }
    /// False if the window has no pixels. No earlier drawing is in progress.
    Result<bool> make(VkExtent2D wanted) {
        VulkanDevice& gpu = *device_->vulkan();
        destroy_chain();
        VkSurfaceCapabilitiesKHR can{};
        VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu.physical, surface_->handle(), &can);
        if (result != VK_SUCCESS) return failed("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", result);
        extent_ = can.currentExtent;
        if (extent_.width == UINT32_MAX)
            extent_ = {std::clamp(wanted.width, can.minImageExtent.width, can.maxImageExtent.width),
                       std::clamp(wanted.height, can.minImageExtent.height, can.maxImageExtent.height)};
        if (extent_.width == 0 || extent_.height == 0) return false;
        auto info = vulkan_struct<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
        info.surface = surface_->handle();
        info.minImageCount = std::max(can.minImageCount, 3U);
        if (can.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
        info.imageFormat = format_.format;
        info.imageColorSpace = format_.colorSpace;
        info.imageExtent = extent_;
        info.imageArrayLayers = 1;
        info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
        info.preTransform = can.currentTransform;
        info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
        info.presentMode = mode_;
        info.clipped = VK_TRUE;
        result = vkCreateSwapchainKHR(gpu.device, &info, nullptr, &chain_);
        if (result != VK_SUCCESS) return failed("vkCreateSwapchainKHR", result);
        images_ = vulkan_list<VkImage>(vkGetSwapchainImagesKHR, gpu.device, chain_);
        if (images_.empty()) return gpu_error(gpu.facts.name + " has no pictures for this window");
        outdated_ = false;
        return true;
    }
    void destroy_chain() {
        if (!chain_) return;
        VulkanDevice& gpu = *device_->vulkan();
        if (!device_->lost()) {
            // Drawing is done; presentation may not be.
            const std::lock_guard lock(gpu.queue_mutex);
            vkQueueWaitIdle(gpu.queue);
        }
        vkDestroySwapchainKHR(gpu.device, chain_, nullptr);
        chain_ = VK_NULL_HANDLE;
        images_.clear();
    }
    Error failed(const char* call, VkResult result) {
        if (result == VK_ERROR_SURFACE_LOST_KHR) device_->lose();
        return device_->vulkan()->failed(call, result);
    }
    /// False if the chain must be remade first, or no image is free.
    Result<bool> acquire(std::uint32_t& index) {
        VulkanDevice& gpu = *device_->vulkan();
        constexpr std::uint64_t patience_ns = 100'000'000;
        VkResult result =
            vkAcquireNextImageKHR(gpu.device, chain_, patience_ns, VK_NULL_HANDLE, acquired_, &index);
        // A covered window may have no free image: `present` then tries once more with a new chain.
        if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_TIMEOUT || result == VK_NOT_READY)
            return false;
        if (result == VK_SUBOPTIMAL_KHR) outdated_ = true;
        if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR)
            return failed("vkAcquireNextImageKHR", result);
        acquiring_ = true;
        const std::chrono::nanoseconds patience =
            std::min<std::chrono::nanoseconds>(device_->patience(), GpuDevice::longest_picture);
        result =
            vkWaitForFences(gpu.device, 1, &acquired_, VK_TRUE, static_cast<std::uint64_t>(patience.count()));
        if (result == VK_TIMEOUT) device_->lose();
        if (result != VK_SUCCESS) return failed("vkWaitForFences", result);
        acquiring_ = false;
        vkResetFences(gpu.device, 1, &acquired_);
        return true;
    }
    void record_copy(GpuCommands& commands, const GpuImage& canvas, VkImage to) const {
        record_transition(commands, to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        stretch_image(commands, canvas, to, extent_);
        record_transition(commands, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                          VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    }

    std::shared_ptr<GpuDevice> device_;
    std::unique_ptr<WindowSurface> surface_;
    VkSurfaceFormatKHR format_{};
    VkPresentModeKHR mode_ = VK_PRESENT_MODE_FIFO_KHR;
    VkSwapchainKHR chain_ = VK_NULL_HANDLE;
    VkExtent2D extent_{};
    std::vector<VkImage> images_;
    VkFence acquired_ = VK_NULL_HANDLE;
    bool outdated_ = false;
    bool acquiring_ = false;  // the window system has yet to signal the fence
};

std::atomic<bool> met_fault{false};  // of the connection, during a call
std::atomic<bool> met_no_window{false};
thread_local bool may_throw = false;  // the window's thread, in `while_connected`

/// The connection ended during a call of GLFW.
struct DisplayLost {};

/// Does the work, or as much of it as is done when the display goes away. Not in another one's work.
void while_connected(const auto& work) {
    may_throw = true;
    try {
        work();
    } catch (const DisplayLost&) {
    }
    may_throw = false;
}

/// XErrorEvent; its layout is part of Xlib's ABI.
struct XRefusal {
    int type;
    void* display;
    unsigned long resource, serial;
    unsigned char error, request, minor_request;
};
constexpr unsigned char bad_window = 3, bad_drawable = 9;

/// Handler of refused requests: without it, Xlib ends the program.
int note_refusal(void*, XRefusal* refusal) {
    if (refusal->error == bad_window || refusal->error == bad_drawable) met_no_window = true;
    return 0;
}

/// GLFW's connection to an X server. By default Xlib ends the program if the server goes away, or another
/// program destroys the window. With this class, requests for a destroyed window do nothing, and a call
/// during which the server goes away is left by a DisplayLost: another request in it would write to an
/// address that Xlib does not have any more. Without an X server the class does nothing.
class XConnection {
public:
    /// Call after glfwInit.
    void open() {
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
        display_ = display;
        set_on_refusal(note_refusal);
        set_on_fault([](void*) { return 0; });
        set_on_exit(
            display,
            [](void*, void*) {
                met_fault = true;
                if (may_throw) throw DisplayLost();
            },
            nullptr);
        socket_ = socket_of(display);
    }
    bool is_open() const { return socket_ >= 0; }
    /// The server has gone away. Xlib, and so GLFW, is unusable then.
    bool is_lost() const { return is_open() && (met_fault || is_hung_up(socket_)); }
    /// Another program has destroyed the window: the X server refused a request for that reason.
    bool has_lost_window() const { return is_open() && met_no_window; }
    /// Waits for input on the connection or two other sockets, for `longest` at most.
    void wait(std::chrono::milliseconds longest, int other, int another) const {
        std::array<pollfd, 3> look{
            {{is_lost() ? -1 : socket_, POLLIN, 0}, {other, POLLIN, 0}, {another, POLLIN, 0}}};
        poll(look.data(), look.size(), static_cast<int>(longest.count()));
    }
    /// Keeps the display awake while the connection lives.
    void keep_awake() const {
        if (is_open()) keep_screen_awake(display_);
    }

private:
    void* display_ = nullptr;
    int socket_ = -1;
};

Error no_display() {
    const char* why = nullptr;
    glfwGetError(&why);
    return {ErrorKind::gpu,
            "there is no display to open a window on (" + std::string(why ? why : "no reason given") +
                "); run it in a desktop session, or without a window",
            {{Setting::headless}}};
}

/// All of GLFW, and so all input, runs on a separate thread, the window's thread: keys are processed while
/// the main thread draws, waits for a GPU or opens something. (GLFW must be used by one thread; only on macOS
/// must that be the main one.) A thread of its own presents each picture while the main thread waits, so that
/// a display that hangs does not keep the program: 0.04 ms of CPU time a picture.
class GlfwScreen final : public Screen {
public:
    /// A display that hangs is left behind, with all that waits for it, once the program is asked to stop.
    static void operator delete(GlfwScreen* screen, std::destroying_delete_t) {
        if (!screen->answers()) {
            ++abandoned_threads;
            return;
        }
        screen->~GlfwScreen();
        ::operator delete(screen);
    }
    ~GlfwScreen() override {
        swapchain_.reset();
        is_over_ = true;  // polled: GLFW may be gone before it could be woken
        if (thread_.joinable()) thread_.join();
    }

    Result<void> open(const ScreenOptions& options) {
        at_once_ = options.at_once;
        std::promise<Result<void>> opened;
        auto outcome = opened.get_future();
        TRY(start_thread(thread_, "window", "that hears keys and mouse",
                         [this, opened = std::move(opened), options]() mutable {
                             Result<void> done = no_display();
                             while_connected([&] {
                                 done = open_window(options);
                                 note_size();
                             });
                             is_over_ = !done;
                             opened.set_value(std::move(done));
                             serve();
                             leave();
                         }));
        is_left_ = !wait_unless_stopped(
            [&] { return outcome.wait_for(std::chrono::seconds(0)) == std::future_status::ready; },
            std::chrono::milliseconds(1));
        return is_left_ ? Result<void>(interrupted_error()) : outcome.get();
    }

    std::vector<std::string> extensions() const override {
        std::uint32_t count = 0;
        const char** names = glfwGetRequiredInstanceExtensions(&count);
        return {names, names + count};
    }

    Result<void> attach(std::shared_ptr<GpuDevice> device) override {
        using Made = Result<std::shared_ptr<Swapchain>>;
        auto made = unless_stopped([before = std::move(swapchain_), device = std::move(device),
                                    window = window_, x_window = x_window()]() mutable -> Made {
            before.reset();
            TRY_ASSIGN(auto surface, WindowSurface::create(device->vulkan(), window, x_window));
            TRY_ASSIGN(auto chain, Swapchain::create(std::move(device), std::move(surface)));
            return Made(std::move(chain));
        });
        is_left_ = !made;
        if (is_left_) return interrupted_error();
        if (!*made) return why(made->error());
        swapchain_ = std::move(**made);
        return {};
    }

    Result<void> health() const override {
        if (connection_.has_lost_window()) return gpu_error("another program has destroyed the window");
        if (!connection_.is_lost()) return {};
        return gpu_error("the display that the window was on has gone away");
    }

    ScreenSize size() const override {
        const std::lock_guard lock(mutex_);
        return size_;
    }

    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (connection_.is_lost()) return {};
        std::unique_lock lock(mutex_);
        has_news_.wait_for(lock, longest, [this] { return !events_.empty(); });
        return std::exchange(events_, {});
    }

    std::string touch_state() const override { return touch_state_; }

    Result<void> present(GpuCommands commands, const GpuImage& canvas) override {
        const ScreenSize now = size();
        const VkExtent2D wanted{static_cast<std::uint32_t>(now.width),
                                static_cast<std::uint32_t>(now.height)};
        const auto shown =
            unless_stopped([chain = swapchain_, commands = std::move(commands), canvas, wanted]() mutable {
                return chain->present(std::move(commands), canvas, wanted);
            });
        if (shown) return *shown ? *shown : why(shown->error());
        // The picture of a display that answers is soon done.
        const auto until = std::chrono::steady_clock::now() + grace;
        while (swapchain_.use_count() > 1 && std::chrono::steady_clock::now() < until)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        is_left_ = swapchain_.use_count() > 1;
        if (is_left_) swapchain_->leave();
        return {};
    }

    void set_title(const std::string& title) override {
        ask([this, title] { glfwSetWindowTitle(window_, title.c_str()); });
    }

    void set_clipboard(const std::string& text) override {
        ask([this, text] { glfwSetClipboardString(window_, text.c_str()); });
    }

    void set_fullscreen(bool on) override {
        ask_and_wait([this, on] { fill_screen(on); });
    }

    void set_size(int width, int height) override {
        ask_and_wait([this, width, height] {
            // Converts pixels at this display's scale to the window's own units.
            const double unit = size_.width > 0 ? size_.scale * units_.first / size_.width : 1;
            glfwSetWindowSize(window_, static_cast<int>(width * unit), static_cast<int>(height * unit));
        });
    }

    void hide_pointer(bool hidden) override {
        if (hidden == hidden_) return;
        hidden_ = hidden;
        ask([this, hidden] {
            glfwSetInputMode(window_, GLFW_CURSOR, hidden ? GLFW_CURSOR_HIDDEN : GLFW_CURSOR_NORMAL);
        });
    }

private:
    /// After a stop, for a display's answer.
    static constexpr std::chrono::milliseconds grace{80};

    // The main thread's functions.
    /// Queues an errand for the window's thread; it is skipped if the display is gone.
    std::uint64_t ask(std::function<void()> errand) {
        std::uint64_t number = 0;
        {
            const std::lock_guard lock(mutex_);
            errands_.push_back(std::move(errand));
            number = ++asked_;
        }
        wake();
        return number;
    }
    /// Like `ask`, but waits until it is done and the window has its new size. Does not wait for a hanging
    /// display once the program is asked to stop.
    void ask_and_wait(std::function<void()> errand) {
        const std::uint64_t number = ask(std::move(errand));
        std::unique_lock lock(mutex_);
        (void)wait_unless_stopped(has_news_, lock, [&] { return done_ >= number; });
    }
    /// Whether the display answers, or the program is not asked to stop.
    bool answers() {
        if (is_left_ || is_over_ || !thread_.joinable()) return !is_left_;
        const std::uint64_t number = ask([this] { note_size(); });
        std::unique_lock lock(mutex_);
        while (!has_news_.wait_for(lock, grace, [&] { return done_ >= number; }))
            if (stop_requested()) return false;
        return true;
    }
    /// The error; if the window is gone, that reason instead.
    Error why(const Error& error) {
        ask_and_wait([this] { note_size(); });
        const auto well = health();
        return well ? error : well.error();
    }
    /// GLFW's window of an X server; 0: it is not one's.
    unsigned long x_window() const {
        auto* const window_of = function<unsigned long(GLFWwindow*)>("glfwGetX11Window");
        return connection_.is_open() && window_of ? window_of(window_) : 0;
    }
    void wake() const { connection_.is_open() ? wake_.wake() : glfwPostEmptyEvent(); }

    // The rest runs on the window's thread.
    Result<void> open_window(const ScreenOptions& options) {
        glfwInitHint(GLFW_JOYSTICK_HAT_BUTTONS, GLFW_FALSE);
#ifdef GLFW_PLATFORM  // since 3.4, which would try Wayland first: `connection_` supports X11 only
        if (std::getenv("DISPLAY") || !std::getenv("WAYLAND_DISPLAY"))
            glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
        if (!glfwInit()) return no_display();
        connection_.open();
        if (options.awake) connection_.keep_awake();
        if (!glfwVulkanSupported())
            return Error{
                ErrorKind::gpu,
                "there is no Vulkan that can show pictures in a window; touchable check says what there is "
                "(Debian: mesa-vulkan-drivers)"};
        glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
        glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
        glfwWindowHint(GLFW_AUTO_ICONIFY, options.stays ? GLFW_FALSE : GLFW_TRUE);
        const auto [width, height] = fitted(options);
        window_ = glfwCreateWindow(width, height, "touchable", nullptr, nullptr);
        if (!window_) return no_display();
        glfwSetWindowSizeLimits(window_, 320, 200, GLFW_DONT_CARE, GLFW_DONT_CARE);
        glfwSetWindowUserPointer(window_, this);
        listen();
        listen_for_touches();
        if (options.fullscreen) fill_screen(true);
        return {};
    }

    /// The size, limited to the display's work area.
    static std::pair<int, int> fitted(const ScreenOptions& options) {
        int x = 0, y = 0, width = 0, height = 0;
        if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor())
            glfwGetMonitorWorkarea(monitor, &x, &y, &width, &height);
        if (width <= 0 || height <= 0) return {options.width, options.height};
        return {std::min(options.width, width), std::min(options.height, height)};
    }

    /// Runs until the window closes; polls, because `is_over_` wakes nothing.
    void serve() {
        constexpr std::chrono::milliseconds look_again{32};
        constexpr unsigned size_again = 3;  // polls: queries the X server, which reports a lost window
        for (unsigned k = 1; !is_over_; ++k) {
            while_connected([&] {
                do_errands();
                if (k % size_again == 0) note_size();
                read_events();
            });
            if (connection_.is_open())
                connection_.wait(look_again, touches_ ? touches_->socket() : -1, wake_.descriptor());
            else
                glfwWaitEventsTimeout(std::chrono::duration<double>(look_again).count());
        }
    }

    void do_errands() {
        wake_.forget();
        std::vector<std::function<void()>> errands;
        std::uint64_t asked = 0;
        {
            const std::lock_guard lock(mutex_);
            if (done_ == asked_) return;
            errands.swap(errands_);
            asked = asked_;
        }
        for (const auto& errand : errands)
            if (!connection_.is_lost()) errand();
        note_size();
        const std::lock_guard lock(mutex_);
        done_ = asked;
        has_news_.notify_all();
    }

    void leave() {
        touches_.reset();
        if (connection_.is_lost()) return;
        while_connected([this] {
            if (window_) glfwDestroyWindow(window_);
            glfwTerminate();
        });
    }

    void fill_screen(bool on) {
        const bool is = glfwGetWindowMonitor(window_) != nullptr;
        if (is == on) return;
        if (on) {
            glfwGetWindowPos(window_, &place_[0], &place_[1]);
            glfwGetWindowSize(window_, &place_[2], &place_[3]);
            GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
            const GLFWvidmode* const mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
            if (mode)
                glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
        } else {
            glfwSetWindowMonitor(window_, nullptr, place_[0], place_[1], place_[2], place_[3], 0);
        }
    }

    void note_size() {
        if (!window_ || connection_.is_lost()) return;
        ScreenSize size;
        std::pair<int, int> units{1, 1};
        glfwGetWindowSize(window_, &units.first, &units.second);
        glfwGetFramebufferSize(window_, &size.width, &size.height);
        float scale_x = 1, scale_y = 1;
        glfwGetWindowContentScale(window_, &scale_x, &scale_y);
        size.scale = static_cast<double>(scale_x);
        if (connection_.is_lost()) return;
        units_ = units;
        const std::lock_guard lock(mutex_);
        size_ = size;
    }

    /// Reads touches first: then it is known whether GLFW's pointer events are a finger's.
    void read_events() {
        if (connection_.is_lost()) return;
        if (touches_)
            for (InputEvent& event : touches_->take()) {
                std::tie(event.x, event.y) = pixels(event.x, event.y);
                add(std::move(event));
            }
        glfwPollEvents();
    }

    void listen_for_touches() {
        if (x_window() == 0) {
            touch_state_ = "touch screen: one finger (this is not X11)";
            return;
        }
        auto opened = TouchScreen::open(x_window());
        touch_state_ = opened ? "touch screen: every finger touches"
                              : "touch screen: one finger (" + opened.error().message + ")";
        if (opened) touches_ = std::move(*opened);
    }

    /// X's pointer follows a finger, which has its own events.
    bool pointer_is_finger() const {
        return touches_ && touches_->has_pointer();
    }

    static GlfwScreen& of(GLFWwindow* window) {
        return *static_cast<GlfwScreen*>(glfwGetWindowUserPointer(window));
    }
    void add(InputEvent event) {
        if (event.kind == InputEvent::Kind::key && at_once_) at_once_(event);
        const std::lock_guard lock(mutex_);
        events_.push_back(std::move(event));
        has_news_.notify_all();
    }

    /// Converts the window's own units to pixels of the picture.
    std::pair<double, double> pixels(double x, double y) const {
        if (units_.first < 1 || units_.second < 1) return {x, y};
        return {x * size_.width / units_.first, y * size_.height / units_.second};
    }

    void listen() {
        using Kind = InputEvent::Kind;
        glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
            if (of(window).pointer_is_finger()) return;
            const auto [px, py] = of(window).pixels(x, y);
            of(window).add({.kind = Kind::moved, .x = px, .y = py});
        });
        glfwSetCursorEnterCallback(window_, [](GLFWwindow* window, int entered) {
            if (!entered && !of(window).pointer_is_finger()) of(window).add({.kind = Kind::left_window});
        });
        glfwSetWindowFocusCallback(window_, [](GLFWwindow* window, int focused) {
            if (!focused) of(window).add({.kind = Kind::left_window});
        });
        glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int held) {
            constexpr const char* names[] = {"left", "right", "middle"};
            if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
            // The release of a button pressed before the finger came is still reported.
            if (action != GLFW_RELEASE && of(window).pointer_is_finger()) return;
            of(window).add({.kind = action == GLFW_RELEASE ? Kind::released : Kind::pressed,
                            .word = names[button],
                            .control = (held & GLFW_MOD_CONTROL) != 0,
                            .shift = (held & GLFW_MOD_SHIFT) != 0});
        });
        glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double notches) {
            const bool control = glfwGetKey(window, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                                 glfwGetKey(window, GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
            of(window).add({.kind = Kind::wheel, .y = notches, .control = control});
        });
        glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int code, int action, int held) {
            of(window).repeats_ = action == GLFW_REPEAT;
            const std::string name = name_of_key(key, glfwGetKeyName(key, code));
            if (name.empty()) return;
            of(window).add({.kind = action == GLFW_RELEASE ? Kind::key_released : Kind::key,
                            .word = name,
                            .control = (held & GLFW_MOD_CONTROL) != 0,
                            .shift = (held & GLFW_MOD_SHIFT) != 0,
                            .repeated = action == GLFW_REPEAT});
        });
        // Comes after its key event.
        glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned character) {
            const std::string name = name_of_sign(character);
            if (!name.empty())
                of(window).add({.kind = Kind::key, .word = name, .repeated = of(window).repeats_});
        });
        glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* window, int, int) {
            of(window).note_size();
            of(window).add({.kind = Kind::resized});
        });
        // A window that was covered: at rest nothing else would show its picture again.
        glfwSetWindowRefreshCallback(window_,
                                     [](GLFWwindow* window) { of(window).add({.kind = Kind::resized}); });
        glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
            for (int k = 0; k < count; ++k) of(window).add({.kind = Kind::dropped, .word = paths[k]});
        });
        glfwSetWindowCloseCallback(window_,
                                   [](GLFWwindow* window) { of(window).add({.kind = Kind::close}); });
    }

    std::thread thread_;
    Wake wake_;  // wakes the window's thread
    std::atomic<bool> is_over_{false};
    XConnection connection_;
    GLFWwindow* window_ = nullptr;
    std::string touch_state_;
    std::function<void(InputEvent&)> at_once_;
    // The main thread's data.
    std::shared_ptr<Swapchain> swapchain_;
    bool hidden_ = false;
    bool is_left_ = false;  // a thread waits for the display, and is not waited for
    // Shared data.
    mutable std::mutex mutex_;
    std::condition_variable has_news_;  // an event came, or an errand is done
    ScreenSize size_;                   // last known; written by the window's thread
    std::vector<InputEvent> events_;
    std::vector<std::function<void()>> errands_;
    std::uint64_t asked_ = 0, done_ = 0;
    // The window's thread's data.
    std::pair<int, int> units_{1, 1};       // the window's size, in its own units
    std::unique_ptr<TouchScreen> touches_;  // null: the first finger is the pointer
    int place_[4] = {0, 0, 1280, 720};      // before full screen: x, y, width, height
    bool repeats_ = false;
};

/// Whether UTF-8 of two bytes is a Latin letter, such as one with an accent, up to U+024F.
bool is_latin_letter(const char* printed) {
    const auto first = static_cast<unsigned char>(*printed);
    return first >= 0xC3 && first <= 0xC9;
}

}  // namespace

std::string name_of_key(int key, const char* printed) {
    constexpr struct {
        int key;
        const char* name;
    } functions[] = {
        {GLFW_KEY_SPACE, "space"},   {GLFW_KEY_LEFT, "left"},      {GLFW_KEY_RIGHT, "right"},
        {GLFW_KEY_UP, "up"},         {GLFW_KEY_DOWN, "down"},      {GLFW_KEY_HOME, "home"},
        {GLFW_KEY_END, "end"},       {GLFW_KEY_TAB, "tab"},        {GLFW_KEY_ESCAPE, "escape"},
        {GLFW_KEY_ENTER, "enter"},   {GLFW_KEY_KP_ENTER, "enter"}, {GLFW_KEY_BACKSPACE, "backspace"},
        {GLFW_KEY_DELETE, "delete"}, {GLFW_KEY_F1, "f1"},          {GLFW_KEY_F11, "f11"},
        {GLFW_KEY_F12, "f12"},       {GLFW_KEY_PAGE_UP, "pageup"}, {GLFW_KEY_PAGE_DOWN, "pagedown"}};
    for (const auto& function : functions)
        if (function.key == key) return function.name;
    const auto is_in = [](char c, char first, char last) { return c >= first && c <= last; };
    if (printed && std::strlen(printed) == 1 && (is_in(*printed, 'a', 'z') || is_in(*printed, '0', '9')))
        return printed;
    const bool is_bound_sign = printed && binding_of(printed, false, false);
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9 && !is_bound_sign)
        return std::string(1, static_cast<char>('0' + key - GLFW_KEY_0));
    const bool is_latin = printed && (is_in(*printed, '!', '~') || is_latin_letter(printed));
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z && !is_latin)
        return std::string(1, static_cast<char>('a' + key - GLFW_KEY_A));
    return "";
}

std::string name_of_sign(unsigned character) {
    constexpr unsigned arabic_question_mark = 0x61F;
    if (character == arabic_question_mark) return "?";
    const bool is_ascii = character > ' ' && character < 0x7F;
    if (!is_ascii || std::isalnum(static_cast<int>(character))) return "";
    return std::string(1, static_cast<char>(character));
}

Result<std::unique_ptr<Screen>> open_glfw_screen(const ScreenOptions& options) {
    auto screen = std::make_unique<GlfwScreen>();
    TRY(screen->open(options));
    return std::unique_ptr<Screen>(std::move(screen));
}

}  // namespace touchable
