#include "engine/authoring/segmentation.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "engine/authoring/label_memory.hpp"
#include "engine/authoring/region_cleaning.hpp"
#include "engine/authoring/region_merging.hpp"
#include "engine/authoring/segment_figures.hpp"
#include "engine/authoring/superpixels.hpp"

namespace touchable {
namespace {

constexpr long usual_superpixels = 1500;
constexpr int smallest_side = 4;
constexpr std::int64_t smallest_permille = 2;  // of the picture's pixels: a segment
constexpr long pixels_per_thread = 20000;
/// A pixel of which colour changed by more than 12 levels, or depth by 2 %, shows something else.
constexpr std::int32_t same_colour = 48, same_depth = 118;

/// So that one pixel out of so many begins a superpixel.
int side_for(long pixels, long superpixels) {
    int side = 1;
    while (long{side} * side * superpixels < pixels) ++side;
    return side;
}

int superpixel_side(const Scene& scene) {
    return std::max(side_for(long{scene.width} * scene.height, usual_superpixels), smallest_side);
}

std::int32_t smallest_segment(const Scene& scene) {
    return static_cast<std::int32_t>(
        std::max<std::int64_t>(1, std::int64_t{scene.width} * scene.height * smallest_permille / 1000));
}

}  // namespace

struct Segmenter::State {
    State(const Scene& scene, int threads)
        : bands(threads > 0 ? threads : threads_for(long{scene.width} * scene.height, pixels_per_thread)),
          reader(scene),
          superpixels(scene.width, scene.height, superpixel_side(scene)),
          merging(scene.camera, smallest_segment(scene)),
          memory(scene.width, scene.height),
          smallest(smallest_segment(scene)) {
        out.width = scene.width;
        out.height = scene.height;
        out.labels.assign(superpixels.of_pixels().size(), 0);
        known.assign(out.labels.size(), 0);
    }

    void find_known(bool follows);
    std::vector<std::uint16_t> labels_of_superpixels() const;
    void find_regions();
    std::vector<RegionLook> looks() const;
    void label(bool follows);

    RowBands bands;
    FeatureReader reader;
    PixelFeatures now, before;
    Superpixels superpixels;
    RegionMerging merging;
    RegionCleaning cleaning;
    LabelMemory memory;
    SegmentFigures figures;
    std::int32_t smallest;
    std::vector<std::uint16_t> known, regions;  // by pixel: label in the last frame; region, dense
    std::size_t region_count = 0;
    Segmentation out;
};

/// What changed tells nothing of what is there now.
void Segmenter::State::find_known(bool follows) {
    if (!follows || before.depth.size() != now.depth.size()) {
        std::fill(known.begin(), known.end(), std::uint16_t{0});
        return;
    }
    for (std::size_t k = 0; k < known.size(); ++k) {
        const bool is_same = std::abs(now.brightness[k] - before.brightness[k]) <= same_colour &&
                             std::abs(now.red_green[k] - before.red_green[k]) <= same_colour &&
                             std::abs(now.yellow_blue[k] - before.yellow_blue[k]) <= same_colour &&
                             std::abs(now.depth[k] - before.depth[k]) <= same_depth;
        known[k] = is_same ? out.labels[k] : std::uint16_t{0};
    }
}

/// The label that most of a superpixel's pixels had, if that is more than half of them.
std::vector<std::uint16_t> Segmenter::State::labels_of_superpixels() const {
    struct Vote {
        std::uint16_t label = 0;
        std::int32_t lead = 0, count = 0;
    };
    const std::vector<std::uint16_t>& of_pixels = superpixels.of_pixels();
    std::vector<Vote> votes(superpixels.all().size());
    for (std::size_t k = 0; k < of_pixels.size(); ++k) {
        if (of_pixels[k] == Superpixels::none) continue;
        Vote& vote = votes[of_pixels[k]];
        if (vote.lead == 0) vote.label = known[k];
        vote.lead += vote.label == known[k] ? 1 : -1;
    }
    for (std::size_t k = 0; k < of_pixels.size(); ++k)
        if (of_pixels[k] != Superpixels::none && votes[of_pixels[k]].label == known[k])
            ++votes[of_pixels[k]].count;
    std::vector<std::uint16_t> labels(votes.size());
    for (std::size_t k = 0; k < votes.size(); ++k)
        if (votes[k].count * 2 > superpixels.all()[k].pixels) labels[k] = votes[k].label;
    return labels;
}

void Segmenter::State::find_regions() {
    for (Superpixel& one : superpixels.all()) one.quantum = reader.quantum(one.depth);
    const std::vector<std::uint16_t>& of_superpixels = merging.merge(superpixels, labels_of_superpixels());
    const std::vector<std::uint16_t>& of_pixels = superpixels.of_pixels();
    regions.resize(of_pixels.size());
    for (std::size_t k = 0; k < regions.size(); ++k)
        regions[k] = of_pixels[k] == Superpixels::none ? RegionCleaning::none : of_superpixels[of_pixels[k]];
    cleaning.clean(regions, out.width, out.height, std::max(2, superpixels.side() * superpixels.side() / 4));
    // Those that are left too small, because there are holes all around them, are no segments.
    std::vector<std::int32_t> pixels(std::size_t{1} << 16);
    for (const std::uint16_t region : regions) ++pixels[region];
    std::vector<std::uint16_t> dense(pixels.size(), RegionCleaning::none);
    region_count = 0;
    for (std::size_t region = 0; region < RegionCleaning::none; ++region)
        if (pixels[region] * 2 >= smallest && pixels[region] > 0)
            dense[region] = static_cast<std::uint16_t>(region_count++);
    for (std::uint16_t& region : regions) region = dense[region];
}

std::vector<RegionLook> Segmenter::State::looks() const {
    struct LookSums {
        std::int64_t x = 0, y = 0, brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;
    };
    std::vector<RegionLook> looks(region_count);
    std::vector<LookSums> all(region_count);
    std::size_t k = 0;
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x, ++k) {
            if (regions[k] == RegionCleaning::none) continue;
            LookSums& sums = all[regions[k]];
            ++looks[regions[k]].pixels;
            sums.x += x, sums.y += y, sums.brightness += now.brightness[k];
            sums.red_green += now.red_green[k], sums.yellow_blue += now.yellow_blue[k];
            sums.depth += now.depth[k];
        }
    for (std::size_t region = 0; region < region_count; ++region) {
        const LookSums& sums = all[region];
        RegionLook& look = looks[region];
        const auto mean = [&](std::int64_t sum) { return static_cast<std::int32_t>(sum / look.pixels); };
        look.x = mean(sums.x), look.y = mean(sums.y), look.brightness = mean(sums.brightness);
        look.red_green = mean(sums.red_green), look.yellow_blue = mean(sums.yellow_blue);
        look.depth = mean(sums.depth);
    }
    return looks;
}

void Segmenter::State::label(bool follows) {
    const std::vector<std::uint16_t> names = memory.name(looks(), regions, out.labels, follows);
    for (std::size_t k = 0; k < regions.size(); ++k)
        out.labels[k] = regions[k] == RegionCleaning::none ? std::uint16_t{0} : names[regions[k]];
    // A superpixel goes on with the label at its middle.
    for (Superpixel& one : superpixels.all()) {
        const std::size_t middle = now.place(one.x, one.y);
        one.label = one.pixels > 0 ? out.labels[middle] : std::uint16_t{0};
    }
}

Segmenter::Segmenter(const Scene& scene, int threads) : state_(std::make_unique<State>(scene, threads)) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

const Segmentation& Segmenter::next(const RawFrame& frame, bool follows) {
    State& state = *state_;
    std::swap(state.now, state.before);
    state.reader.read(frame, state.now, state.bands);
    state.find_known(follows);
    if (!follows) state.superpixels.forget();
    state.superpixels.divide(state.now, state.known, state.bands);
    state.find_regions();
    state.label(follows);
    state.figures.find(frame, state.out, state.bands);
    return state.out;
}

}  // namespace touchable
