// SPDX-License-Identifier: Apache-2.0
#pragma once

// What builds a run's frames: BuilderChoice, as a person chose it; pick_builder, which picks for `auto` by
// the run's needs and the machine; RunGpu, the one GPU that builder and window share.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// The GPU of a run, shared by builder and pictures: opened on first use, reopened after a loss. Thread-safe.
class RunGpu {
public:
    /// `request` as in choose_gpu, `window_extensions` as in GpuOptions.
    explicit RunGpu(std::string request, std::vector<std::string> window_extensions = {})
        : request_(std::move(request)), window_extensions_(std::move(window_extensions)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// As `open`, after `measure` (measure_builders, measure_painters) has measured it; reopened if measuring
    /// lost it.
    Result<std::shared_ptr<GpuDevice>> open_measured(
        const std::function<void(const std::shared_ptr<GpuDevice>&)>& measure);
    /// VulkanDevice::take_new_programs of the open device.
    std::optional<VulkanDevice::ProgramsToKeep> take_new_programs();
    /// The GPU's own name; empty before it is open.
    std::string name() const;

private:
    Result<std::shared_ptr<GpuDevice>> open_if_needed();

    const std::string request_;
    const std::vector<std::string> window_extensions_;
    mutable std::mutex mutex_;
    std::shared_ptr<GpuDevice> device_;
    std::optional<GpuFacts::Measured> measured_;
};

/// `--builder` and related options: as typed, or as resolved for a run.
struct BuilderChoice {
    /// Facts that decide which builder costs least; forces do not depend on the builder.
    struct Load {
        Scene scene;        ///< as the run applies it
        bool moves = true;  ///< the clip has more than one frame
        /// A GPU is open to draw the frames, so frames built there need no copy.
        bool drawn = false;
    };

    std::string name = "cpu";
    std::string why{};          ///< one line: why chosen by auto, or in place of the request; empty: as
                                ///< requested
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder and for pictures
    bool error_bars = false;    ///< frames are built with_error_bars
    bool gpu_fallback = false;  ///< no GPU was requested: fall back to the cpu builder without one

    bool names_gpu() const { return gpu != "auto"; }
};

/// The vulkan builder opens and uses `gpu`; other builders do not open it. Errors: ErrorKind::gpu with what
/// is missing if vulkan was requested and there is no such GPU; ErrorKind::usage for the lazy builder with a
/// temporal filter. A GPU lost during the run is no error: the cpu builder takes over, with a warning on
/// stderr.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu);

/// Resolves `--builder auto`: cpu or vulkan, and why. `gpu_is_fast` opens a device, so it is called
/// only if whole frames cost enough for that to pay; it returns whether there is a GPU that is neither a
/// software Vulkan nor measured to be slow (is_fast_builder). Only name and why of the result are set; a
/// GPU's name and the fallback are the caller's.
BuilderChoice pick_builder(const BuilderChoice::Load& load, const std::function<bool()>& gpu_is_fast);

/// Whether a GPU builds a frame in at most twice the CPU's time (which frees the CPU), or was not measured.
/// Software Vulkan runs on the CPU, so false.
bool is_fast_builder(const GpuFacts& facts);

}  // namespace touchable
