// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/surface_kernels.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable::test {

/// The kernels on the GPU that is here, which the validation layer watches; one for all tests of a program.
/// The tests fail without a GPU, and if the layer reports anything.
std::shared_ptr<SurfaceKernels> test_kernels();

/// On that GPU; throws where that cannot be.
std::unique_ptr<VulkanSurfaceBuilder> test_vulkan_builder(const Scene& scene);

/// Few lanes that march whole rows, as on a CPU; many that march segments side by side in memory of
/// their own; and blocks, as on a GPU.
inline constexpr SurfacePlan all_plans[] = {
    {8, 0, false, false}, {8, 4, true, true}, {64, 4, true, true, true}};
std::string plan_text(const SurfacePlan& plan);

/// Builds frames by every builder, in slots that are used again for frames of other sizes.
class BuilderComparison {
public:
    /// The first builder that differs from the reference, and its difference; or nothing.
    std::string difference(const Scene& scene, const RawFrame& raw, const SurfaceFrame& reference,
                           std::span<const SurfacePlan> plans = all_plans);
    /// The lazy builder's, for the last frame.
    const VertexSource& lazy_vertices() const { return *lazy_.vertices; }

private:
    SurfaceFrame cpu_, lazy_, vulkan_;
};

/// Fails with this error from frame `at` on; gives the CPU builder's frames before.
class FailingBuilder final : public SurfaceBuilder {
public:
    FailingBuilder(const Scene& scene, std::int64_t at, Error error)
        : builder_(make_cpu_builder(scene)), at_(at), error_(std::move(error)) {}
    std::string_view name() const override { return "failing"; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (raw.number >= at_) return error_;
        return builder_->build(raw, out);
    }

private:
    std::unique_ptr<SurfaceBuilder> builder_;
    std::int64_t at_;
    Error error_;
};

}  // namespace touchable::test
