#include "player/window/imgui_layer.hpp"

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <set>
#include <utility>

#include "player/window/theme.hpp"

namespace touchable {
namespace {

/// The keys that a text field or a slider knows, as ImGui 1.86 numbers what it is told.
int number_of_key(const std::string& name) {
    constexpr const char* names[] = {"tab",  "left", "right",  "up",        "down",  "pageup", "pagedown",
                                     "home", "end",  "delete", "backspace", "enter", "escape"};
    for (std::size_t k = 0; k < std::size(names); ++k)
        if (name == names[k]) return static_cast<int>(k);
    return -1;
}

void map_keys(ImGuiIO& io) {
    constexpr ImGuiKey keys[] = {
        ImGuiKey_Tab,       ImGuiKey_LeftArrow, ImGuiKey_RightArrow, ImGuiKey_UpArrow, ImGuiKey_DownArrow,
        ImGuiKey_PageUp,    ImGuiKey_PageDown,  ImGuiKey_Home,       ImGuiKey_End,     ImGuiKey_Delete,
        ImGuiKey_Backspace, ImGuiKey_Enter,     ImGuiKey_Escape};
    for (int k = 0; k < static_cast<int>(std::size(keys)); ++k) io.KeyMap[keys[k]] = k;
}

int button_of(const std::string& word) {
    return word == "left" ? 0 : (word == "right" ? 1 : 2);
}

void tell(ImGuiIO& io, const InputEvent& event) {
    using Kind = InputEvent::Kind;
    switch (event.kind) {
        case Kind::moved:
            io.MousePos = ImVec2(static_cast<float>(event.x), static_cast<float>(event.y));
            break;
        case Kind::left_window:
            io.MousePos = ImVec2(-FLT_MAX, -FLT_MAX);
            break;
        case Kind::pressed:
        case Kind::released:
            io.MouseDown[button_of(event.word)] = event.kind == Kind::pressed;
            break;
        case Kind::wheel:
            io.MouseWheel += static_cast<float>(event.y);
            break;
        case Kind::key:
        case Kind::key_released:
            if (const int key = number_of_key(event.word); key >= 0)
                io.KeysDown[key] = event.kind == Kind::key;
            io.KeyCtrl = event.control;
            io.KeyShift = event.shift;
            break;
        case Kind::resized:
        case Kind::dropped:
        case Kind::close:
            break;
    }
}

}  // namespace

Result<std::unique_ptr<ImGuiLayer>> ImGuiLayer::create(std::shared_ptr<GpuDevice> device, double scale) {
    std::unique_ptr<ImGuiLayer> layer(new ImGuiLayer(std::move(device)));
    if (auto made = layer->make_pass(); !made.ok()) return made.error();
    if (auto started = layer->start(scale); !started.ok()) return started.error();
    return layer;
}

ImGuiLayer::~ImGuiLayer() {
    const VkDevice device = device_->vulkan()->device;
    if (context_) {
        ImGui::SetCurrentContext(context_);
        if (on_vulkan_) ImGui_ImplVulkan_Shutdown();
        ImGui::DestroyContext(context_);
    }
    if (framebuffer_) vkDestroyFramebuffer(device, framebuffer_, nullptr);
    if (pass_) vkDestroyRenderPass(device, pass_, nullptr);
    if (pool_) vkDestroyDescriptorPool(device, pool_, nullptr);
}

Result<void> ImGuiLayer::make_pass() {
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
    // After what was drawn below, before what copies the canvas.
    const VkSubpassDependency dependencies[] = {
        {VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
         VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, 0},
        {0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT,
         0}};
    VkRenderPassCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
    info.attachmentCount = 1;
    info.pAttachments = &attachment;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    VkResult result = vkCreateRenderPass(gpu.device, &info, nullptr, &pass_);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateRenderPass", result);
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4};
    VkDescriptorPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    pool.maxSets = 4;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    result = vkCreateDescriptorPool(gpu.device, &pool, nullptr, &pool_);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateDescriptorPool", result);
    return {};
}

Result<void> ImGuiLayer::start(double scale) {
    VulkanDevice& gpu = *device_->vulkan();
    context_ = ImGui::CreateContext();
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    map_keys(io);
    apply_theme(scale);
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = gpu.instance->handle();
    info.PhysicalDevice = gpu.physical;
    info.Device = gpu.device;
    info.QueueFamily = gpu.queue_family;
    info.Queue = gpu.queue;
    info.DescriptorPool = pool_;
    info.MinImageCount = 2;
    info.ImageCount = 2;
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    on_vulkan_ = ImGui_ImplVulkan_Init(&info, pass_);
    if (!on_vulkan_) return Error{ErrorKind::gpu, "the panel cannot be drawn on " + gpu.facts.name};
    return upload_fonts();
}

Result<void> ImGuiLayer::upload_fonts() {
    auto commands = GpuCommands::begin(device_, "fonts");
    if (!commands.ok()) return commands.error();
    ImGui_ImplVulkan_CreateFontsTexture(commands->handle());
    const auto submission = std::move(*commands).submit();
    if (!submission.ok()) return submission.error();
    if (auto done = submission->wait(); !done.ok()) return done;
    ImGui_ImplVulkan_DestroyFontUploadObjects();
    return {};
}

void ImGuiLayer::begin(int width, int height, double seconds, std::span<const InputEvent> events) {
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(static_cast<float>(width), static_cast<float>(height));
    io.DeltaTime = static_cast<float>(seconds > 1e-4 ? seconds : 1e-4);
    // ImGui sees what a button is when a picture begins: of a short click each half gets a picture.
    std::vector<InputEvent> now = std::exchange(later_, {});
    now.insert(now.end(), events.begin(), events.end());
    std::set<std::string> pressed;
    for (const InputEvent& event : now) {
        const bool is_let_go = event.kind == InputEvent::Kind::released && pressed.contains(event.word);
        if (is_let_go || !later_.empty()) {
            later_.push_back(event);
            continue;
        }
        if (event.kind == InputEvent::Kind::pressed) pressed.insert(event.word);
        tell(io, event);
    }
    ImGui_ImplVulkan_NewFrame();
    ImGui::NewFrame();
}

Result<VkFramebuffer> ImGuiLayer::framebuffer_of(const GpuImage& canvas) {
    if (framebuffer_ && canvas_ == canvas.keep_alive()) return framebuffer_;
    VulkanDevice& gpu = *device_->vulkan();
    if (framebuffer_) vkDestroyFramebuffer(gpu.device, framebuffer_, nullptr);
    framebuffer_ = VK_NULL_HANDLE;
    const VkImageView view = canvas.view();
    VkFramebufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    info.renderPass = pass_;
    info.attachmentCount = 1;
    info.pAttachments = &view;
    info.width = canvas.extent().width;
    info.height = canvas.extent().height;
    info.layers = 1;
    const VkResult result = vkCreateFramebuffer(gpu.device, &info, nullptr, &framebuffer_);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateFramebuffer", result);
    canvas_ = canvas.keep_alive();
    return framebuffer_;
}

Result<void> ImGuiLayer::draw(GpuCommands& commands, const GpuImage& canvas) {
    ImGui::SetCurrentContext(context_);
    ImGui::Render();
    const auto framebuffer = framebuffer_of(canvas);
    if (!framebuffer.ok()) return framebuffer.error();
    VkRenderPassBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
    info.renderPass = pass_;
    info.framebuffer = *framebuffer;
    info.renderArea.extent = canvas.extent();
    vkCmdBeginRenderPass(commands.handle(), &info, VK_SUBPASS_CONTENTS_INLINE);
    ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands.handle());
    vkCmdEndRenderPass(commands.handle());
    commands.keep(canvas.keep_alive());
    return {};
}

bool ImGuiLayer::holds_pointer() const {
    return ImGui::IsAnyItemActive();
}

}  // namespace touchable
