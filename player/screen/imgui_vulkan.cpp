#include "player/screen/imgui_vulkan.hpp"

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <utility>

namespace touchable {

Result<std::unique_ptr<ImGuiVulkan>> ImGuiVulkan::create(std::shared_ptr<GpuDevice> device) {
    std::unique_ptr<ImGuiVulkan> made(new ImGuiVulkan(std::move(device)));
    if (auto pass = made->make_pass(); !pass.ok()) return pass.error();
    if (auto started = made->start(); !started.ok()) return started.error();
    return made;
}

ImGuiVulkan::~ImGuiVulkan() {
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

/// To a GPU that hangs; ImGui knows nothing of it from now on.
void ImGuiVulkan::leave() {
    leave_for_good(device_->vulkan());
    if (!is_started_) return;
    ImGuiIO& io = ImGui::GetIO();
    leave_for_good({io.BackendRendererUserData, [](const void*) {}});
    io.BackendRendererUserData = nullptr;
    io.BackendRendererName = nullptr;
    io.BackendFlags &= ~ImGuiBackendFlags_RendererHasVtxOffset;
}

Result<void> ImGuiVulkan::make_pass() {
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

Result<void> ImGuiVulkan::start() {
    VulkanDevice& gpu = *device_->vulkan();
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
    is_started_ = ImGui_ImplVulkan_Init(&info, pass_);
    if (!is_started_) return Error{ErrorKind::gpu, "the panel cannot be drawn on " + gpu.facts.name};
    return upload_fonts();
}

Result<void> ImGuiVulkan::upload_fonts() {
    auto commands = GpuCommands::begin(device_, "fonts");
    if (!commands.ok()) return commands.error();
    ImGui_ImplVulkan_CreateFontsTexture(commands->handle());
    const auto submission = std::move(*commands).submit();
    if (!submission.ok()) return submission.error();
    if (auto done = submission->wait_for_picture(); !done.ok()) return done;
    ImGui_ImplVulkan_DestroyFontUploadObjects();
    return {};
}

Result<VkFramebuffer> ImGuiVulkan::framebuffer_of(const GpuImage& canvas) {
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

Result<void> ImGuiVulkan::draw(GpuCommands& commands, const GpuImage& canvas) {
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

}  // namespace touchable
