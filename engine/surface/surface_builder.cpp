// SPDX-License-Identifier: Apache-2.0
// The plan of a scene's filters, checks of a raw frame, the fallback from one builder to another, and a
// frame's depths.
#include "engine/surface/surface_builder.hpp"

#include <cstdlib>
#include <deque>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

/// The required form of a plane; `bytes` are those of a sample.
struct PlaneForm {
    const char* name;
    int channels, least_bytes, greatest_bytes;
};

/// What is wrong with a plane; empty: nothing.
std::string complaint(const PlaneView& plane, const PlaneForm& form, const Scene& scene) {
    if (plane.width != scene.width || plane.height != scene.height)
        return "is " + size_text(plane.width, plane.height) + ", the scene says " +
               size_text(scene.width, scene.height);
    if (plane.channels != form.channels)
        return "has " + std::to_string(plane.channels) + " channels; must be " +
               std::to_string(form.channels);
    if (plane.bytes_per_sample < form.least_bytes || plane.bytes_per_sample > form.greatest_bytes)
        return "has samples of " + std::to_string(8 * plane.bytes_per_sample) + " bits; must be " +
               std::to_string(8 * form.least_bytes);
    const std::ptrdiff_t row_bytes = std::ptrdiff_t{plane.width} * plane.channels * plane.bytes_per_sample;
    if (plane.height > 1 && std::abs(plane.stride) < row_bytes)
        return "has rows of " + std::to_string(row_bytes) + " bytes, but only " +
               std::to_string(plane.stride) + " from one to the next";
    return {};
}

class FallbackBuilder final : public SurfaceBuilder {
public:
    FallbackBuilder(std::unique_ptr<SurfaceBuilder> first, std::unique_ptr<SurfaceBuilder> second,
                    std::function<void(const std::string&)> told)
        : first_(std::move(first)), second_(std::move(second)), told_(std::move(told)) {}

    std::string_view name() const override { return (first_ ? *first_ : *second_).name(); }
    double built_share() const override { return (first_ ? *first_ : *second_).built_share(); }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (first_) {
            Result<void> built = first_->build(raw, out);
            if (!has_failed(built, raw)) return built;
        }
        return second_->build(raw, out);
    }

    int frames_in_flight() const override { return first_ ? first_->frames_in_flight() : 1; }

    Result<void> begin(const RawFrame& raw) override {
        if (first_) {
            Result<void> begun = first_->begin(raw);
            if (!begun && !has_failed(begun, raw)) return begun;
        }
        in_flight_.push_back(raw);
        return {};
    }

    Result<void> finish(SurfaceFrame& out) override {
        const RawFrame raw = std::move(in_flight_.front());
        in_flight_.pop_front();
        if (first_) {
            Result<void> finished = first_->finish(out);
            if (!has_failed(finished, raw)) return finished;
        }
        return second_->build(raw, out);
    }

private:
    /// Whether the GPU failed; then the second builder builds all frames, also those that the first began.
    bool has_failed(const Result<void>& done, const RawFrame& raw) {
        if (done || done.error().kind != ErrorKind::gpu) return false;
        told_("frame " + std::to_string(raw.number) + ": " + done.error().message + "; the " +
              std::string(second_->name()) + " builder goes on");
        first_.reset();  // frames it built keep what they need
        return true;
    }

    std::unique_ptr<SurfaceBuilder> first_, second_;
    std::function<void(const std::string&)> told_;
    std::deque<RawFrame> in_flight_;
};

}  // namespace

Result<void> SurfaceBuilder::begin(const RawFrame& raw) {
    begun_ = raw;
    return {};
}

Result<void> SurfaceBuilder::finish(SurfaceFrame& out) {
    const RawFrame raw = std::exchange(begun_, {});
    return build(raw, out);
}

FilterPlan::FilterPlan(const Scene& scene) : stored(scene.depth) {
    const FilterSettings& asked = scene.filter;
    assert(asked.median == 0 || asked.median == 3 || asked.median == 5);
    if (const auto filter = flying_pixels(scene)) filters.push_back({*filter, flying_reach, coding()});
    if (asked.fill_holes > 0) filters.push_back({HoleFilling{asked.fill_holes}, asked.fill_holes, coding()});
    if (asked.median > 0) filters.push_back({MedianWindow{asked.median}, asked.median / 2, coding()});
    if (const auto filter = temporal_filter(scene))
        filters.push_back({*filter, std::nullopt, filter->coding});
    if (const auto filter = terrace_filter(scene))
        filters.push_back({*filter, filter->reach, filter->coding});
}

std::optional<int> FilterPlan::reach() const {
    int sum = 0;
    for (const Stage& stage : filters) {
        if (!stage.reach) return std::nullopt;
        sum += *stage.reach;
    }
    return sum;
}

Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene) {
    const auto frame = [&] { return "frame " + std::to_string(raw.number) + ": "; };
    if (raw.depth.empty()) return input_error(frame() + "there is no depth plane");
    const PlaneForm depth = scene.depth.kind == DepthCodingKind::hue
                                ? PlaneForm{"depth", 3, 1, 1}
                                : PlaneForm{"depth", 1, scene.depth_bits > 8 ? 2 : 1, 2};
    const std::pair<const PlaneView&, PlaneForm> planes[] = {
        {raw.depth, depth},
        {raw.colour, {"colour", 3, 1, 1}},
        {raw.haptic, {"haptic", 3, 1, 1}},
        {raw.height, {"height", 1, 1, 2}},
    };
    for (const auto& [plane, form] : planes) {
        if (plane.empty()) continue;
        if (const std::string wrong = complaint(plane, form, scene); !wrong.empty())
            return input_error(frame() + "the " + form.name + " plane " + wrong);
    }
    return {};
}

CodePicture code_picture(const PlaneView& depth, const DepthCoding& coding) {
    CodePicture picture{depth.width, depth.height, {}};
    picture.codes.reserve(pixel_count(depth.width, depth.height));
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) {
            const std::uint16_t code = stored_code(depth, coding, x, y);
            picture.codes.push_back(coding.is_valid(code) ? int{code} : CodePicture::invalid);
        }
    return picture;
}

std::unique_ptr<SurfaceBuilder> make_fallback_builder(std::unique_ptr<SurfaceBuilder> first,
                                                      std::unique_ptr<SurfaceBuilder> second,
                                                      std::function<void(const std::string&)> told) {
    return std::make_unique<FallbackBuilder>(std::move(first), std::move(second), std::move(told));
}

std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& given) {
    // Every pixel is read: one by one, a lazy frame would take longer than building the whole frame.
    SurfaceFrame whole;
    const bool is_lazy = given.codes.empty() && make_cpu_builder(scene)->build(given.raw, whole);
    const SurfaceFrame& frame = is_lazy ? whole : given;
    const auto width = static_cast<std::size_t>(scene.width);
    const std::size_t pixels = width * static_cast<std::size_t>(scene.height);
    constexpr std::size_t enough = std::size_t{4096} * 4096;
    const std::size_t step = pixels > enough ? pixels / enough | 1U : 1;  // odd: no even width divides it
    std::vector<double> depths;
    depths.reserve(pixels / step);
    until_stopped(pixels / step, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first * step; k < last * step; k += step)
            if (const DepthSample sample =
                    frame.vertices->at(static_cast<int>(k % width), static_cast<int>(k / width));
                sample.valid)
                depths.push_back(sample.depth);
    });
    if (depths.empty()) depths.push_back(scene.depth.far);
    return depths;
}

double quantile(std::vector<double>& depths, double share) {
    return sorted_element(depths, static_cast<std::size_t>(share * static_cast<double>(depths.size() - 1)));
}

}  // namespace touchable
