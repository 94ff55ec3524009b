// SPDX-License-Identifier: Apache-2.0
#include "bench/real/other_filters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "bench/clocks.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/surface/opencv_pipeline.hpp"

namespace touchable {
namespace {

using Pictures = std::vector<std::vector<float>>;

/// librealsense's spatial filter (a recursive domain transform, after Gastal and Oliveira 2011) and temporal
/// filter (an exponential mean), with its names. Depth is in stored codes, or in 1/32 pixels of disparity.
struct RealSense {
    float alpha = 0.5F, delta = 20;  ///< of the spatial filter
    int magnitude = 2;
    float temporal_alpha = 0.4F, temporal_delta = 20;

    /// One way along a row or a column.
    void smooth(float* first, std::ptrdiff_t step, int count) const {
        float state = *first, before = *first;
        for (int n = 1; n < count; ++n) {
            float& at = first[n * step];
            const float now = at;
            const bool is_near = before > 0 && now > 0 && std::fabs(before - now) < delta;
            state = is_near ? now * alpha + state * (1 - alpha) : now;
            at = state;
            before = now;
        }
    }

    void apply(std::vector<float>& picture, std::vector<float>& last, int width, int height) const {
        for (int n = 0; n < magnitude; ++n) {
            for (int y = 0; y < height; ++y) {
                float* const row = picture.data() + pixel_place(0, y, width);
                smooth(row, 1, width);
                smooth(row + width - 1, -1, width);
            }
            for (int x = 0; x < width; ++x) {
                smooth(picture.data() + x, width, height);
                smooth(picture.data() + pixel_place(x, height - 1, width), -width, height);
            }
        }
        last.resize(picture.size());
        for (std::size_t k = 0; k < picture.size(); ++k) {
            const float now = picture[k], before = last[k];
            if (now <= 0) continue;
            if (before > 0 && std::fabs(now - before) < temporal_delta)
                picture[k] = temporal_alpha * now + (1 - temporal_alpha) * before;
            last[k] = picture[k];
        }
    }
};

/// As many finer codes as fit: nothing is lost by storing what a filter returns.
Scene with_finer_codes(Scene scene) {
    DepthCoding& depth = scene.depth;
    const int factor = 65535 / std::max(1, static_cast<int>(depth.valid_max));
    depth.scale /= factor;
    depth.code_max = 65535;
    depth.invalid_code_count = 1;
    depth.invalid_codes[0] = 0;
    derive_valid_range(depth);
    scene.filter = {};
    return scene;
}

/// Codes of the frames as floats, 0 where there is none, and back in the codes of `to`.
Pictures floats_of(const std::vector<RawFrame>& raws, const DepthCoding& coding) {
    Pictures pictures;
    for (const RawFrame& raw : raws) {
        auto& picture = pictures.emplace_back();
        for (int y = 0; y < raw.depth.height; ++y)
            for (int x = 0; x < raw.depth.width; ++x) {
                const std::uint16_t code = stored_code(raw.depth, coding, x, y);
                picture.push_back(coding.is_valid(code) ? static_cast<float>(code) : 0.0F);
            }
    }
    return pictures;
}

std::vector<RawFrame> frames_of(const Pictures& pictures, const std::vector<RawFrame>& raws, double factor) {
    std::vector<RawFrame> frames;
    for (std::size_t n = 0; n < raws.size(); ++n) {
        auto codes = std::make_shared<std::vector<std::uint16_t>>();
        for (const float value : pictures[n])
            codes->push_back(static_cast<std::uint16_t>(std::clamp(value * factor + 0.5, 0.0, 65535.0)));
        RawFrame& frame = frames.emplace_back(raws[n]);
        frame.depth = plane_of_codes(codes->data(), raws[n].depth.width, raws[n].depth.height);
        frame.storage = std::move(codes);
    }
    return frames;
}

/// A filter on a picture of stored codes as floats, 0 where there is no depth. `last`: what it keeps from
/// picture to picture; empty before the first.
using Filter = std::function<void(std::vector<float>& picture, std::vector<float>& last)>;

/// A setting of a filter of others.
struct Other {
    std::string family;
    bool is_default = false;
    std::function<Filter(const Scene&)> on;

    Filtering filtering(const Scene& scene) const {
        Filtering filtering(with_finer_codes(scene));
        const double factor = scene.depth.scale / filtering.scene.depth.scale;
        filtering.before = [filter = on(scene), coding = scene.depth,
                            factor](const std::vector<RawFrame>& raws) {
            Pictures pictures = floats_of(raws, coding);
            std::vector<float> last;
            for (auto& picture : pictures) filter(picture, last);
            return frames_of(pictures, raws, factor);
        };
        return filtering;
    }
};

double mm_of_code(const Scene& scene) {
    return 1000 * scene.depth.scale * scene.metres_per_unit;
}

Other real_sense(const RealSense& set, bool is_default, bool is_stereo) {
    return {"rs", is_default, [=](const Scene& scene) -> Filter {
                constexpr double baseline_mm = 50, parts = 32;
                const auto disparity =
                    static_cast<float>(baseline_mm * scene.camera.fx * parts / mm_of_code(scene));
                return [=, width = scene.width, height = scene.height](auto& picture, auto& last) {
                    const auto invert = [&] {
                        for (float& value : picture) value = value > 0 ? disparity / value : 0;
                    };
                    if (is_stereo) invert();
                    set.apply(picture, last, width, height);
                    if (is_stereo) invert();
                };
            }};
}

/// `sigma_mm`: of depth; `sigma_px`: of place.
Other bilateral(int side, double sigma_mm, double sigma_px, bool is_default) {
    return {"cv", is_default, [=](const Scene& scene) -> Filter {
                const double sigma = sigma_mm / mm_of_code(scene);
                return [=, width = scene.width, height = scene.height](auto& picture, auto&) {
                    opencv_bilateral(picture, width, height, side, sigma, sigma_px);
                };
            }};
}

std::vector<Other> others(bool is_stereo) {
    std::vector<Other> all{real_sense({}, true, is_stereo)};
    for (const float alpha : {0.25F, 0.5F, 0.7F})
        for (const float delta : {6.0F, 20.0F, 50.0F})
            for (const int magnitude : {1, 2, 5})
                for (const float temporal : {0.1F, 0.4F})
                    all.push_back(real_sense({alpha, delta, magnitude, temporal, std::max(delta, 20.0F)},
                                             false, is_stereo));
    if (!has_opencv()) return all;
    all.push_back(bilateral(13, 30, 4.5, true));  // as KinectFusion's followers set it
    for (const int side : {5, 9, 13})
        for (const double sigma_mm : {3.0, 10.0, 30.0, 90.0})
            for (const double sigma_px : {1.5, 4.5})
                all.push_back(bilateral(side, sigma_mm, sigma_px, false));
    return all;
}

/// CPU time of a picture: ours into a surface, that of others into a picture.
Result<double> cost_ms(const Other* other, const Filtering& filtering, const Judges& judges) {
    if (!other) {
        Figures cost;
        if (auto done = measure_cost(filtering.scene, judges.raws, 40, cost); !done) return done.error();
        return cost.front().value;
    }
    const Filter filter = other->on(judges.scene);
    const Pictures pictures = floats_of(judges.raws, judges.scene.depth);
    std::vector<float> picture, last;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < 20; ++n) {
        picture = pictures[n % pictures.size()];
        const std::int64_t begin = process_cpu_ns();
        filter(picture, last);
        least = std::min(least, static_cast<double>(process_cpu_ns() - begin) * 1e-6);
    }
    return least;
}

struct Judged {
    const Other* other = nullptr;  ///< null: ours
    Filtering filtering;
    double degrees = 0, pen_pct = 0;
};

Result<void> report(const std::string& name, const Judged& judged, const Judges& judges, Figures& figures) {
    figures.push_back({name + "_deg", judged.degrees, "deg"});
    figures.push_back({name + "_pen_pct", judged.pen_pct, "%"});
    if (judges.lag_mm) {
        const auto lag = judges.lag_mm(judged.filtering);
        if (!lag) return lag.error();
        figures.push_back({name + "_lag_mm", *lag, "mm"});
    }
    const auto cost = cost_ms(judged.other, judged.filtering, judges);
    if (!cost) return cost.error();
    figures.push_back({name + "_cpu_ms", *cost, "ms"});
    return {};
}

}  // namespace

Result<void> compare_with_others(const SensorModel& model, const Judges& judges, Figures& figures) {
    const auto judge = [&](const Other* other) -> Result<Judged> {
        const auto on = [&](const std::vector<RawFrame>& raws, const Scene& scene) {
            return other ? other->filtering(scene) : Filtering(chosen_filters(raws, scene));
        };
        Judged judged{other, on(judges.raws, judges.scene)};
        const auto degrees = judges.degrees(judged.filtering);
        if (!degrees) return degrees.error();
        const auto pen_pct = kept_relief_pct(model, on);
        if (!pen_pct) return pen_pct.error();
        judged.degrees = *degrees;
        judged.pen_pct = *pen_pct;
        return judged;
    };
    const auto ours = judge(nullptr);
    if (!ours) return ours.error();
    if (auto done = report("ours", *ours, judges, figures); !done) return done;
    std::map<std::string, Judged> best;
    const std::vector<Other> all = others(model.is_stereo);
    for (const Other& other : all) {
        auto judged = judge(&other);
        if (!judged) return judged.error();
        const auto add = [&](const std::string& name) {
            const auto found = best.try_emplace(name, *judged).first;
            if (judged->degrees < found->second.degrees) found->second = *judged;
        };
        if (other.is_default) add(other.family + "_default");
        add(other.family + "_least");
        if (judged->pen_pct >= ours->pen_pct) add(other.family);
    }
    for (const auto& [name, judged] : best) {
        if (auto done = report(name, judged, judges, figures); !done) return done;
        figures.push_back({name + "_times", judged.degrees / ours->degrees, ""});
    }
    return {};
}

}  // namespace touchable
