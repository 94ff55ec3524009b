// SPDX-License-Identifier: Apache-2.0
#include "tests/surface/test_gpu.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "engine/gpu/vulkan_instance.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

class TestGpu : public testing::Environment {
public:
    std::shared_ptr<SurfaceKernels> kernels() {
        if (!kernels_) {
            // Stays in memory, so that the leak checker can name it (tests/lsan.supp).
            dlopen("libVkLayer_khronos_validation.so", RTLD_NOW | RTLD_NODELETE);
            auto device = GpuDevice::open({.validation = true});
            if (!device) throw std::runtime_error(device.error().message);
            messages_ = (*device)->messages();
            kernels_ = std::make_shared<SurfaceKernels>(*device);
        }
        return kernels_;
    }
    void TearDown() override {
        kernels_.reset();
        if (!messages_) return;
        for (const std::string& message : messages_->all()) ADD_FAILURE() << message;
    }

private:
    std::shared_ptr<SurfaceKernels> kernels_;
    std::shared_ptr<const GpuMessages> messages_;
};

TestGpu& test_gpu = dynamic_cast<TestGpu&>(*testing::AddGlobalTestEnvironment(new TestGpu));

}  // namespace

std::shared_ptr<SurfaceKernels> test_kernels() {
    return test_gpu.kernels();
}

std::unique_ptr<VulkanSurfaceBuilder> test_vulkan_builder(const Scene& scene) {
    auto made = make_vulkan_builder(scene, test_kernels(), all_plans[0]);
    if (!made) throw std::runtime_error(made.error().message);
    return std::move(*made);
}

std::string plan_text(const SurfacePlan& plan) {
    return "groups of " + std::to_string(plan.group_size) + ", segments of " +
           std::to_string(plan.segment_texels) + (plan.along_x ? " along x" : "") +
           (plan.copies ? ", copied" : "") + (plan.blocks ? ", blocks" : "");
}

std::string BuilderComparison::difference(const Scene& scene, const RawFrame& raw,
                                          const SurfaceFrame& reference, std::span<const SurfacePlan> plans) {
    const auto built = [&](SurfaceBuilder& builder, SurfaceFrame& slot) -> std::string {
        const auto result = builder.build(raw, slot);
        return result ? first_difference(reference, slot) : result.error().message;
    };
    std::string what = built(*make_cpu_builder(scene), cpu_);
    if (!what.empty()) return "cpu: " + what;
    for (const VectorUnit unit : usable_vector_units()) {
        what = built(*make_cpu_builder(scene, {1, unit}), cpu_);
        if (!what.empty()) return "vectors " + std::to_string(static_cast<int>(unit)) + ": " + what;
    }
    for (const SurfacePlan& plan : plans) {
        auto builder = make_vulkan_builder(scene, test_kernels(), plan);
        what = builder ? built(**builder, vulkan_) : builder.error().message;
        if (!what.empty()) return "vulkan, " + plan_text(plan) + ": " + what;
    }
    if (const auto lazy = make_lazy_builder(scene)->build(raw, lazy_); !lazy) return lazy.error().message;
    if (lazy_.coding != reference.coding) return "lazy: another coding";
    for (const SurfaceFrame* frame : {&vulkan_, &cpu_, &lazy_}) {
        const std::string by = frame == &vulkan_ ? "vulkan: " : frame == &cpu_ ? "cpu: " : "lazy: ";
        what = first_vertex_difference(reference, *frame->vertices);
        if (what.empty()) what = first_tile_not_enclosed(reference, *frame->vertices);
        if (!what.empty()) return by + what;
    }
    return {};
}

}  // namespace touchable::test
