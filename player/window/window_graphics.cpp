// SPDX-License-Identifier: Apache-2.0
// Draws the window's pictures: on a GPU, with Dear ImGui's Vulkan backend; or in the CPU's memory. Also the
// headless screen.

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>
#include <vulkan/vulkan.h>

#include <mutex>
#include <thread>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/picture/image.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/draw/pictures.hpp"
#include "player/window/clip_picture.hpp"

namespace touchable {
namespace {

/// Draws ImGui's draw data over a canvas (VK_FORMAT_R8G8B8A8_UNORM). One at a time; the ImGuiLayer must
/// outlive it. Leaks the objects that a hanging GPU may still use.
class ImGuiVulkan : NonCopyable {
public:
    static Result<std::unique_ptr<ImGuiVulkan>> create(std::shared_ptr<GpuDevice> device) {
        std::unique_ptr<ImGuiVulkan> made(new ImGuiVulkan(std::move(device)));
        TRY(made->make_pass());
        TRY(made->start());
        return made;
    }
    ~ImGuiVulkan() {
        if (!device_->comes_to_rest()) {
            leave();
            return;
        }
        const VkDevice device = device_->vulkan()->device;
        if (is_started_) ImGui_ImplVulkan_Shutdown();
        if (framebuffer_) vkDestroyFramebuffer(device, framebuffer_, nullptr);
        if (pass_) vkDestroyRenderPass(device, pass_, nullptr);
        if (pool_) vkDestroyDescriptorPool(device, pool_, nullptr);
    }

    /// Records drawing over `canvas`, which is in VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL before and in
    /// VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL after.
    Result<void> draw(GpuCommands& commands, const GpuImage& canvas) {
        TRY_ASSIGN(const auto framebuffer, framebuffer_of(canvas));
        auto info = vulkan_struct<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
        info.renderPass = pass_;
        info.framebuffer = framebuffer;
        info.renderArea.extent = canvas.extent();
        vkCmdBeginRenderPass(commands.handle(), &info, VK_SUBPASS_CONTENTS_INLINE);
        ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands.handle());
        vkCmdEndRenderPass(commands.handle());
        commands.keep(canvas.keep_alive());
        return {};
    }

private:
    explicit ImGuiVulkan(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    /// Leaks the backend to a hanging GPU, and detaches it from ImGui.
    void leave() {
        leave_for_good(device_->vulkan());
        if (!is_started_) return;
        ImGuiIO& io = ImGui::GetIO();
        leave_for_good({io.BackendRendererUserData, [](const void*) {}});
        io.BackendRendererUserData = nullptr;
        io.BackendRendererName = nullptr;
        io.BackendFlags &= ~ImGuiBackendFlags_RendererHasVtxOffset;
    }
    Result<void> make_pass() {
        VulkanDevice& gpu = *device_->vulkan();
        VkAttachmentDescription attachment{};
        attachment.format = VK_FORMAT_R8G8B8A8_UNORM;
        attachment.samples = VK_SAMPLE_COUNT_1_BIT;
        attachment.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
        attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        attachment.initialLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        attachment.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
        VkSubpassDescription subpass{};
        subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &reference;
        // After the drawing below, before the canvas is copied.
        const VkSubpassDependency dependencies[] = {
            {VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
             VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
             VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, 0},
            {0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
             VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
             VK_ACCESS_TRANSFER_READ_BIT, 0}};
        auto info = vulkan_struct<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
        info.attachmentCount = 1;
        info.pAttachments = &attachment;
        info.subpassCount = 1;
        info.pSubpasses = &subpass;
        info.dependencyCount = 2;
        info.pDependencies = dependencies;
        TRY(gpu.checked("vkCreateRenderPass", vkCreateRenderPass(gpu.device, &info, nullptr, &pass_)));
        const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4};
        auto pool = vulkan_struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
        pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
        pool.maxSets = 4;
        pool.poolSizeCount = 1;
        pool.pPoolSizes = &size;
        return gpu.checked("vkCreateDescriptorPool",
                           vkCreateDescriptorPool(gpu.device, &pool, nullptr, &pool_));
    }
    Result<void> start() {
        VulkanDevice& gpu = *device_->vulkan();
        ImGui_ImplVulkan_InitInfo info{};
        info.Instance = gpu.instance_handle();
        info.PhysicalDevice = gpu.physical;
        info.Device = gpu.device;
        info.QueueFamily = gpu.queue_family;
        info.Queue = gpu.queue;
        info.PipelineCache = gpu.programs;
        info.DescriptorPool = pool_;
        info.MinImageCount = 2;
        info.ImageCount = 2;
        info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
        is_started_ = ImGui_ImplVulkan_Init(&info, pass_);
        if (!is_started_) return gpu_error("the panel cannot be drawn on " + gpu.facts.name);
        return upload_fonts();
    }
    Result<void> upload_fonts() {
// ImGui 1.90 submits the upload itself, and waits for it.
#if IMGUI_VERSION_NUM >= 19000
        VulkanDevice& gpu = *device_->vulkan();
        const std::lock_guard lock(gpu.queue_mutex);
        if (ImGui_ImplVulkan_CreateFontsTexture()) return {};
        return gpu_error("the panel's letters cannot be uploaded to " + gpu.facts.name);
#else
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "fonts", GpuTiming::none));
        ImGui_ImplVulkan_CreateFontsTexture(commands.handle());
        TRY_ASSIGN(const auto submission, std::move(commands).submit());
        TRY(submission.wait_for_picture());
        ImGui_ImplVulkan_DestroyFontUploadObjects();
        return {};
#endif
    }
    Result<VkFramebuffer> framebuffer_of(const GpuImage& canvas) {
        if (framebuffer_ && canvas_ == canvas.keep_alive()) return framebuffer_;
        VulkanDevice& gpu = *device_->vulkan();
        if (framebuffer_) vkDestroyFramebuffer(gpu.device, framebuffer_, nullptr);
        framebuffer_ = VK_NULL_HANDLE;
        const VkImageView view = canvas.view();
        auto info = vulkan_struct<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
        info.renderPass = pass_;
        info.attachmentCount = 1;
        info.pAttachments = &view;
        info.width = canvas.extent().width;
        info.height = canvas.extent().height;
        info.layers = 1;
        TRY(gpu.checked("vkCreateFramebuffer",
                        vkCreateFramebuffer(gpu.device, &info, nullptr, &framebuffer_)));
        canvas_ = canvas.keep_alive();
        return framebuffer_;
    }

    std::shared_ptr<GpuDevice> device_;
    bool is_started_ = false;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
    std::shared_ptr<const void> canvas_;  // the framebuffer's canvas
};

/// Copies `canvas`, which is in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, into the CPU's memory.
Result<Image> read_back(std::shared_ptr<GpuDevice> device, const GpuImage& canvas) {
    const VkExtent2D extent = canvas.extent();
    const std::size_t pixels = std::size_t{extent.width} * extent.height;
    TRY_ASSIGN(auto buffer, GpuBuffer::create(*device, "picture read back", pixels * 4, GpuMemory::readback));
    TRY_ASSIGN(auto commands, GpuCommands::begin(device, "read back", GpuTiming::none));
    copy_from_image(commands, canvas, buffer);
    TRY(std::move(commands).run());
    Image image{static_cast<int>(extent.width), static_cast<int>(extent.height), 1, 3, {}};
    image.samples.resize(pixels * 3);
    const auto bytes = buffer.mapped<std::uint8_t>();
    for (std::size_t k = 0; k < pixels; ++k)
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.samples[3 * k + channel] = bytes[4 * k + channel];
    return image;
}

/// Stretches a drawn image over another one; both are ready for drawing then.
void record_stretch(GpuCommands& commands, const GpuImage& from, const GpuImage& to) {
    constexpr VkImageLayout drawn = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    record_transition(commands, from, drawn, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    record_transition(commands, to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    stretch_image(commands, from, to.handle(), to.extent());
    record_transition(commands, from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, drawn);
    record_transition(commands, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, drawn);
}

/// Draws on a canvas that stays on the GPU.
class GpuGraphics final : public WindowGraphics {
public:
    GpuGraphics(std::shared_ptr<GpuDevice> device, Screen& screen)
        : device_(std::move(device)), screen_(screen) {}

    Result<void> open(std::string_view painter) {
        TRY(assign(drawing_, SurfaceDrawing::create(device_, painter)));
        return take_letters();
    }

    std::string_view painter() const override { return drawing_->painter(); }
    std::string gpu() const override { return device_->facts().name; }
    bool is_lost() const override { return device_->lost(); }
    bool can_stretch() const override { return true; }
    bool is_quick() const override {
        return !drawing_->thins_vertices() && device_->facts().kind != GpuKind::software;
    }

    Result<void> take_letters() override {
        imgui_.reset();  // only one may exist
        TRY_ASSIGN(imgui_, ImGuiVulkan::create(device_));
        return {};
    }

    Result<void> begin() override {
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "window", GpuTiming::none));
        commands_.emplace(std::move(commands));
        return {};
    }

    Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int step) override {
        if (drawing_->thins_vertices())
            return drawing_->show(*commands_, field, pair, colour, lighting, step);
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "surface", GpuTiming::none));
        TRY(drawing_->show(commands, field, pair, colour, lighting, step));
        return std::move(commands).run();
    }

    Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                      int width, int height) override {
        TRY(reserve(canvas_, "canvas", width, height));
        is_kept_ = false;
        const auto is_drawn_at = [&](int times) {
            return times * camera.width == width && times * camera.height == height;
        };
        if (is_drawn_at(1) || (drawing_->thins_vertices() && (is_drawn_at(2) || is_drawn_at(4))))
            return drawing_->draw(*commands_, camera, fingers, sizes, canvas_);
        TRY(reserve(small_, "small picture", camera.width, camera.height));
        TRY(drawing_->draw(*commands_, camera, fingers, sizes, small_));
        const bool is_fine = camera.width == 4 * width;  // a stretch reads four samples a pixel
        if (is_fine) {
            TRY(reserve(half_, "half as large a picture", 2 * width, 2 * height));
            record_stretch(*commands_, small_, half_);
        }
        record_stretch(*commands_, is_fine ? half_ : small_, canvas_);
        return {};
    }

    void keep_drawn() override {
        const VkExtent2D size = canvas_.extent();
        is_kept_ = static_cast<bool>(
            reserve(kept_, "kept picture", static_cast<int>(size.width), static_cast<int>(size.height)));
        if (is_kept_) record_stretch(*commands_, canvas_, kept_);
    }
    bool draw_again() override {
        if (is_kept_) record_stretch(*commands_, kept_, canvas_);
        return is_kept_;
    }

    Result<void> finish() override {
        TRY(imgui_->draw(*commands_, canvas_));
        GpuCommands commands = std::move(*commands_);
        commands_.reset();
        return screen_.present(std::move(commands), canvas_);
    }

    Result<Image> picture() const override {
        if (!canvas_) return usage_error("there is no picture yet that could be kept");
        return read_back(device_, canvas_);
    }

private:
    Result<void> reserve(GpuImage& image, const char* name, int width, int height) const {
        if (image && image.is_of_size(width, height)) return {};
        TRY_ASSIGN(image, GpuImage::create(*device_, name, width, height, VK_FORMAT_R8G8B8A8_UNORM));
        return {};
    }

    std::shared_ptr<GpuDevice> device_;
    Screen& screen_;
    std::unique_ptr<SurfaceDrawing> drawing_;
    std::unique_ptr<ImGuiVulkan> imgui_;
    GpuImage canvas_, small_, half_;  // small_: stretched over the canvas, if used, by way of half_
    GpuImage kept_;                   // the canvas without words
    bool is_kept_ = false;
    std::optional<GpuCommands> commands_;  // of the current picture
};

/// Surface and fingers in the CPU's memory, without Vulkan and without the panel.
class CpuGraphics final : public WindowGraphics {
public:
    std::string_view painter() const override { return "cpu"; }
    Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int) override {
        drawing_.show(field, pair, colour, lighting);
        return {};
    }
    Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                      int width, int /*height*/) override {
        TRY_ASSIGN(picture_, drawing_.draw(camera, fingers, sizes, std::max(camera.width / width, 1)));
        return {};
    }
    Result<Image> picture() const override {
        if (!picture_) return usage_error("there is no picture yet that could be kept");
        return *picture_;
    }

private:
    CpuDrawing drawing_;
    const Image* picture_ = nullptr;
};

class HeadlessScreen final : public Screen {
public:
    explicit HeadlessScreen(const ScreenOptions& options) : size_{options.width, options.height, 1} {}

    ScreenSize size() const override { return size_; }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        std::this_thread::sleep_for(longest);
        return {};
    }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    void set_size(int width, int height) override { size_ = {width, height, 1}; }

private:
    ScreenSize size_;
};

}  // namespace

Result<std::unique_ptr<WindowGraphics>> make_gpu_graphics(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter, Screen& screen) {
    auto graphics = std::make_unique<GpuGraphics>(std::move(device), screen);
    TRY(graphics->open(painter));
    return std::unique_ptr<WindowGraphics>(std::move(graphics));
}

std::unique_ptr<WindowGraphics> make_cpu_graphics() {
    return std::make_unique<CpuGraphics>();
}

std::unique_ptr<Screen> make_headless_screen(const ScreenOptions& options) {
    return std::make_unique<HeadlessScreen>(options);
}

}  // namespace touchable
