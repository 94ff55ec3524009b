// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/run/touch_run.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/view.hpp"
#include "shaders/cut_rule.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/stand_ins.hpp"
#include "tests/temporary_files.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

constexpr const char* painters[] = {"cpu", "raster", "mesh"};

/// Five fingers on the globe: two touch, one of them from behind, and one leaves a thread.
std::vector<FingerMark> fingers_on(const Viewpoint::Subject& subject, double size) {
    std::vector<FingerMark> fingers(5);
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        FingerMark& finger = fingers[k];
        finger.proxy = subject.points[subject.points.size() * (k + 1) / 6];
        finger.goal = finger.proxy - glm::dvec3(0.4, 0.2, 1.5) * (2 * size);
        finger.touching = k % 2 == 0;
        finger.force = glm::dvec3(-0.4, 0.5, 1.2) * static_cast<double>(k);
        for (int n = 0; k > 1 && n < 40; ++n)
            finger.trail.push_back(
                finger.proxy + glm::dvec3(-0.2 * (40 - n), 0.05 * (40 - n) * std::sin(0.1 * n), 0.1) * size);
        // One that rests leaves the same point again.
        if (finger.trail.size() > 20)
            finger.trail.insert(finger.trail.begin() + 20, 3, glm::dvec3(finger.trail[20]));
        if (!finger.trail.empty())
            finger.trail.insert(finger.trail.end(), 3, glm::dvec3(finger.trail.back()));
    }
    return fingers;
}

/// A globe that is shown, with fingers on it.
struct TouchedGlobe {
    ViewCamera camera(const char* words, int width = 600, int height = 400) const {
        return make_view(*parse_viewpoint(words), shown->scene, subject.middle, width, height);
    }

    double blend = 0;
    std::unique_ptr<Shown> shown = shown_scene("globe", 203, 133);
    PlaneView colour = shown->raw_prev.colour;
    FramePair pair = shown->pair(blend);
    HeightField field = shown->field(blend);
    Viewpoint::Subject subject = subject_of(field);
    MarkSizes sizes = mark_sizes(shown->scene, subject.middle);
    std::vector<FingerMark> fingers = fingers_on(subject, sizes.finger_radius);
    ViewSurface surface = make_view_surface(field, colour);
};

class Drawing : public GpuTest {
protected:
    void show(SurfaceDrawing& drawing, const TouchedGlobe& globe) {
        show(drawing, globe.field, globe.pair, globe.colour);
    }
    std::unique_ptr<SurfaceDrawing> drawing_by(const char* painter) {
        return must(SurfaceDrawing::create(gpu, painter));
    }
    Image picture_of(SurfaceDrawing& drawing, const ViewCamera& camera, std::span<const FingerMark> fingers,
                     const MarkSizes& sizes, const GpuImage& target) {
        auto commands = must(GpuCommands::begin(gpu, "picture"));
        must(drawing.draw(commands, camera, fingers, sizes, target));
        return read(std::move(commands), target);
    }
    Image read(GpuCommands commands, const GpuImage& target) {
        record_transition(commands, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        const VkExtent2D extent = target.extent();
        const std::size_t pixels = std::size_t{extent.width} * extent.height;
        const auto back = must(GpuBuffer::create(*gpu, "back", 4 * pixels, GpuMemory::readback));
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(commands.handle(), target.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                               back.handle(), 1, &region);
        commands.keep(back.keep_alive());
        must(must(std::move(commands).submit()).wait());
        Image image{static_cast<int>(extent.width), static_cast<int>(extent.height), 1, 3, {}};
        for (const PackedColour colour : back.mapped<PackedColour>().first(pixels))
            for (const unsigned shift : {0U, 8U, 16U})
                image.samples.push_back(static_cast<std::uint8_t>(colour >> shift));
        return image;
    }
    GpuImage target_of(int width, int height) {
        return must(GpuImage::create(*gpu, "target", width, height, VK_FORMAT_R8G8B8A8_UNORM));
    }
    void show(SurfaceDrawing& drawing, const HeightField& field, const FramePair& pair,
              const PlaneView& colour, Lighting lighting = Lighting::full) {
        auto commands = must(GpuCommands::begin(gpu, "show"));
        must(drawing.show(commands, field, pair, colour, lighting));
        must(must(std::move(commands).submit()).wait());
    }
};

/// The same by the CPU: painter, background and fingers, a sample a pixel.
/// As `drawing` draws it: the CPU smooths silhouettes of turned views.
Image cpu_picture(const SurfaceDrawing& drawing, const ViewSurface& surface, const ViewCamera& camera,
                  std::span<const FingerMark> fingers, const MarkSizes& sizes) {
    PicturePlanes planes = before_background(plain_picture(surface, camera));
    if (drawing.thins_vertices() && !is_own_view(camera))
        Silhouettes().smooth(planes.colours, planes.z, planes.width, planes.height);
    LightPicture picture = on_background(std::move(planes));
    draw_fingers(fingers, sizes, camera, picture);
    return developed(picture, 1);
}

/// Pixels of which a channel differs by more than `most` of 255.
std::size_t different(const Image& a, const Image& b, int most) {
    EXPECT_EQ(a.samples.size(), b.samples.size());
    std::size_t count = 0;
    for (std::size_t k = 0; k + 2 < std::min(a.samples.size(), b.samples.size()); k += 3) {
        int worst = 0;
        for (std::size_t channel = k; channel < k + 3; ++channel)
            worst = std::max(worst, std::abs(a.samples[channel] - b.samples[channel]));
        count += worst > most;
    }
    return count;
}

/// Whether a channel of a pixel of `a` is by more than `most` of 255 outside the range of values that `b` has
/// there and in the eight pixels around.
bool is_outside(const Image& a, const Image& b, int x, int y, int most) {
    const auto value = [&](const Image& image, int u, int v, int channel) {
        return int{image.samples[static_cast<std::size_t>((v * image.width + u) * 3 + channel)]};
    };
    for (int channel = 0; channel < 3; ++channel) {
        int least = 255, greatest = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, b.height - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, b.width - 1); ++u) {
                least = std::min(least, value(b, u, v, channel));
                greatest = std::max(greatest, value(b, u, v, channel));
            }
        const int here = value(a, x, y, channel);
        if (here < least - most || here > greatest + most) return true;
    }
    return false;
}

/// Pixels whose colour in one picture lies between no colours that the other has within a pixel. An edge that
/// is smooth in one picture and hard in the other is no such place, however much of a pixel it covers.
std::size_t different_beyond_edges(const Image& a, const Image& b, int most) {
    EXPECT_EQ(a.samples.size(), b.samples.size());
    if (a.samples.size() != b.samples.size()) return a.samples.size();
    std::size_t count = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            count += is_outside(a, b, x, y, most) || is_outside(b, a, x, y, most);
    return count;
}

TEST_F(Drawing, SurfaceMatchesCpu) {
    const auto shown = shown_scene("globe", 203, 133);
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        EXPECT_EQ(drawing->painter(), painter);
        const GpuImage target = target_of(300, 200);
        for (const double blend : {0.0, 0.35})
            for (const bool coloured : {true, false}) {
                const HeightField field = shown->field(blend);
                const PlaneView colour = coloured ? shown->raw_prev.colour : PlaneView{};
                show(*drawing, field, shown->pair(blend), colour);
                const ViewSurface surface = make_view_surface(field, colour);
                for (const char* words : {"own", "orbit:az=25,el=10"}) {
                    const ViewCamera camera = view_of(*shown, field, words, 300, 200);
                    const Image expected = cpu_picture(*drawing, surface, camera, {}, {});
                    // Silhouettes, by the rounding of a projection; light by 2, and a rounding.
                    EXPECT_LE(different(picture_of(*drawing, camera, {}, {}, target), expected, 3), 60U)
                        << painter << ", " << words << ", " << blend;
                }
            }
    }
}

/// The window's picture on a machine that draws by the CPU alone.
TEST_F(Drawing, CpuTwinMatchesCpuOnDevice) {
    const TouchedGlobe globe{.blend = 0.35};
    const auto other = shown_scene("step", 60, 40);
    const ViewCamera camera = globe.camera("orbit:az=25,el=10");
    const GpuImage target = target_of(600, 400);
    const auto by_cpu = drawing_by("cpu");
    CpuDrawing twin;
    // Before anything is shown there is background.
    EXPECT_EQ(must(twin.draw(camera, {}, globe.sizes))->samples,
              picture_of(*by_cpu, camera, {}, globe.sizes, target).samples);
    twin.show(other->field(), other->pair(), {}, Lighting::full);
    must(twin.draw(camera, {}, globe.sizes));
    const std::vector<std::uint8_t> bytes(203 * 133 * 3, 77);
    const PlaneView map{bytes.data(), 203 * 3, 203, 133, 1, 3};
    for (const auto& [plane, lighting] :
         {std::pair(globe.colour, Lighting::full), std::pair(PlaneView{}, Lighting::full),
          std::pair(map, Lighting::values)}) {
        show(*by_cpu, globe.field, globe.pair, plane, lighting);
        twin.show(globe.field, globe.pair, plane, lighting);
        const Image bare = *must(twin.draw(camera, {}, globe.sizes));
        EXPECT_LE(different(bare, picture_of(*by_cpu, camera, {}, globe.sizes, target), 3), 120U);
        const Image touched = *must(twin.draw(camera, globe.fingers, globe.sizes));
        const std::size_t marked = different(touched, bare, 3);
        EXPECT_GT(marked, 3000U);
        EXPECT_LE(different(touched, picture_of(*by_cpu, camera, globe.fingers, globe.sizes, target), 12),
                  marked / 8);
        EXPECT_EQ(must(twin.draw(camera, {}, globe.sizes))->samples, bare.samples)
            << "a finger left something";
    }
}

TEST_F(Drawing, FingersMatchCpu) {
    const TouchedGlobe globe;
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        show(*drawing, globe);
        const GpuImage target = target_of(600, 400);
        for (const char* words : {"own", "orbit:az=25,el=10", "orbit:az=-60,el=30,zoom=2"}) {
            const ViewCamera camera = globe.camera(words);
            const Image bare = cpu_picture(*drawing, globe.surface, camera, {}, {});
            const Image expected = cpu_picture(*drawing, globe.surface, camera, globe.fingers, globe.sizes);
            const Image drawn = picture_of(*drawing, camera, globe.fingers, globe.sizes, target);
            const std::size_t marked = different(bare, expected, 3);
            EXPECT_GT(marked, 3000U);
            // The rest: the thin ends of threads, which are ribbons on a GPU, and the tips of arrows.
            EXPECT_LE(different_beyond_edges(drawn, expected, 12), marked / 32) << painter << ", " << words;
        }
    }
}

/// Before the surface and half within it, from near and far: no pixel differs but those of edges.
TEST_F(Drawing, BallsMatchCpu) {
    const TouchedGlobe globe;
    std::vector<FingerMark> fingers(3);
    for (std::size_t k = 0; k < fingers.size(); ++k)
        fingers[k].proxy = globe.subject.points[globe.subject.points.size() * (k + 1) / 4] +
                           glm::dvec3(0, 0, static_cast<double>(k) * globe.sizes.finger_radius);
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        show(*drawing, globe);
        const GpuImage target = target_of(600, 400);
        for (const char* words : {"own", "orbit:az=-60,el=30,zoom=3", "orbit:az=10,el=0,zoom=0.3"}) {
            const ViewCamera camera = globe.camera(words);
            const Image expected = cpu_picture(*drawing, globe.surface, camera, fingers, globe.sizes);
            double round = 0;  // pixels
            for (const FingerMark& finger : fingers)
                round += 2 * 3.15 * camera.focal * globe.sizes.finger_radius /
                         glm::distance(camera.eye, finger.proxy);
            EXPECT_LE(static_cast<double>(different(
                          picture_of(*drawing, camera, fingers, globe.sizes, target), expected, 12)),
                      1.5 * round)
                << painter << ", " << words;
        }
    }
}

/// Dents alone, as far as they are seen beside the fingers that make them.
TEST_F(Drawing, DentsMatchCpu) {
    const TouchedGlobe globe;
    auto fingers = globe.fingers;
    for (FingerMark& finger : fingers) {
        finger.under = under_finger(globe.field, finger.proxy, globe.sizes.finger_radius);
        if (finger.under) finger.under->height = 0;
        if (finger.touching) finger.given_way = glm::dvec3(0.5, -0.3, -0.9) * globe.sizes.finger_radius;
    }
    auto unmoved = fingers;
    for (FingerMark& finger : unmoved) finger.given_way = {};
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        show(*drawing, globe);
        const GpuImage target = target_of(600, 400);
        for (const char* words : {"own", "orbit:az=30,el=0", "orbit:az=-60,el=30,zoom=2"}) {
            const ViewCamera camera = globe.camera(words);
            const Image flat = picture_of(*drawing, camera, unmoved, globe.sizes, target);
            const Image dented = picture_of(*drawing, camera, fingers, globe.sizes, target);
            const std::size_t gave_way = different(flat, dented, 3);
            EXPECT_GT(gave_way, 800U) << painter << ", " << words;
            const Image expected_flat = cpu_picture(*drawing, globe.surface, camera, unmoved, globe.sizes);
            const Image expected = cpu_picture(*drawing, globe.surface, camera, fingers, globe.sizes);
            // Beyond what differs without a dent: the edges of fingers. By the CPU colours come from places
            // that are exact to half a pixel.
            const bool by_cpu = drawing->painter() == "cpu";
            const int most = by_cpu ? 24 : 4;
            EXPECT_LE(different(dented, expected, most),
                      different(flat, expected_flat, most) + gave_way / (by_cpu ? 20 : 50))
                << painter << ", " << words;
            EXPECT_EQ(picture_of(*drawing, camera, unmoved, globe.sizes, target).samples, flat.samples)
                << "a dent left something";
        }
    }
}

TEST_F(Drawing, RepeatsToTheBit) {
    const auto shown = shown_scene("globe", 96, 64);
    const HeightField field = shown->field();
    const Viewpoint::Subject subject = subject_of(field);
    const MarkSizes sizes = mark_sizes(shown->scene, subject.middle);
    const auto fingers = fingers_on(subject, sizes.finger_radius);
    const ViewCamera camera = view_of(*shown, field, "orbit:az=20,el=8", 240, 160);
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        const GpuImage target = target_of(240, 160), other = target_of(240, 160);
        // All of it in one submission: what is uploaded for the second surface leaves the first alone.
        auto commands = must(GpuCommands::begin(gpu, "pictures"));
        must(drawing->show(commands, field, shown->pair(), {}, Lighting::full));
        must(drawing->draw(commands, camera, {}, sizes, other));
        must(drawing->show(commands, shown->field(0.5), shown->pair(0.5), shown->raw_prev.colour,
                           Lighting::full));
        must(drawing->draw(commands, camera, {}, sizes, target));
        must(drawing->draw(commands, camera, fingers, sizes, target));
        const Image first = read(std::move(commands), target);
        const Image before = read(must(GpuCommands::begin(gpu, "before")), other);
        EXPECT_LE(different(before, cpu_picture(*drawing, make_view_surface(field, {}), camera, {}, {}), 3),
                  40U)
            << painter;
        EXPECT_EQ(first.samples, picture_of(*drawing, camera, fingers, sizes, target).samples) << painter;
        const Image bare = picture_of(*drawing, camera, {}, sizes, target);
        EXPECT_GT(different(first, bare, 3), 100U);
        // A finger that goes leaves nothing behind.
        const ViewSurface surface = make_view_surface(shown->field(0.5), shown->raw_prev.colour);
        EXPECT_LE(different(bare, cpu_picture(*drawing, surface, camera, {}, {}), 3), 40U) << painter;
    }
}

/// Commands are discarded when something fails after them, or a window's picture is not finished.
TEST_F(Drawing, RedoesDiscardedCommands) {
    const auto shown = shown_scene("cliffs", 150, 100);
    const HeightField field = shown->field();
    const PlaneView colour = shown->raw_prev.colour;
    const ViewCamera camera = view_of(*shown, field, "orbit:az=25,el=10", 300, 200);
    const GpuImage target = target_of(300, 200);
    for (const char* painter : painters) {
        const auto unbroken = drawing_by(painter), drawing = drawing_by(painter);
        const Image background = picture_of(*unbroken, camera, {}, {}, target);
        show(*unbroken, field, shown->pair(), colour);
        const Image expected = picture_of(*unbroken, camera, {}, {}, target);
        EXPECT_GT(different(background, expected, 3), 5000U);

        const auto forget = [&](const auto& record) {
            auto commands = must(GpuCommands::begin(gpu, "forgotten"));
            must(record(commands));
        };
        forget([&](GpuCommands& commands) {
            return drawing->show(commands, field, shown->pair(), colour, Lighting::full);
        });
        // The CPU needs no commands.
        const Image& there = drawing->painter() == "cpu" ? expected : background;
        EXPECT_EQ(picture_of(*drawing, camera, {}, {}, target).samples, there.samples) << painter;
        show(*drawing, field, shown->pair(), colour);
        forget([&](GpuCommands& commands) { return drawing->draw(commands, camera, {}, {}, target); });
        EXPECT_EQ(picture_of(*drawing, camera, {}, {}, target).samples, expected.samples) << painter;
    }
}

/// A smaller picture over the whole target, with fingers as fine as that.
TEST_F(Drawing, CpuStretchesSurfaceAlone) {
    const TouchedGlobe globe;
    const auto drawing = drawing_by("cpu");
    show(*drawing, globe);
    const ViewCamera small = globe.camera("orbit:az=25,el=10", 150, 100),
                     whole = globe.camera("orbit:az=25,el=10", 600, 400);
    const Image drawn = picture_of(*drawing, small, {}, globe.sizes, target_of(150, 100));
    std::vector<PackedColour> pixels, twice(300 * 200), four_times(600 * 400);
    for (std::size_t k = 0; k < drawn.samples.size(); k += 3)
        pixels.push_back(pack_colour(drawn.samples[k], drawn.samples[k + 1], drawn.samples[k + 2]));
    double_picture(pixels, 150, 100, twice);
    double_picture(twice, 300, 200, four_times);
    Image expected{600, 400, 1, 3, {}};
    for (const PackedColour colour : four_times)
        for (const unsigned shift : {0U, 8U, 16U})
            expected.samples.push_back(static_cast<std::uint8_t>(colour >> shift));
    const GpuImage target = target_of(600, 400);
    const Image bare = picture_of(*drawing, small, {}, globe.sizes, target);
    EXPECT_EQ(bare.samples, expected.samples);
    const Image touched = picture_of(*drawing, small, globe.fingers, globe.sizes, target),
                fine = picture_of(*drawing, whole, globe.fingers, globe.sizes, target),
                fine_bare = picture_of(*drawing, whole, {}, globe.sizes, target);
    const std::size_t marked = different(touched, bare, 12);
    EXPECT_GT(marked, 3000U);
    EXPECT_NEAR(static_cast<double>(marked), static_cast<double>(different(fine, fine_bare, 12)),
                0.05 * static_cast<double>(marked));
}

TEST_F(Drawing, AcceptsChangingSizes) {
    const auto large = shown_scene("globe", 150, 100), small = shown_scene("step", 60, 40);
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        int height = 90;
        for (const auto* shown : {small.get(), large.get(), small.get()}) {
            const HeightField field = shown->field();
            show(*drawing, field, shown->pair(), {});
            height += 50;
            const ViewCamera camera = view_of(*shown, field, "orbit:az=15,el=5", 210, height % 140 + 20);
            const GpuImage target = target_of(camera.width, camera.height);
            const Image expected = cpu_picture(*drawing, make_view_surface(field, {}), camera, {}, {});
            EXPECT_LE(different(picture_of(*drawing, camera, {}, {}, target), expected, 3), 60U) << painter;
        }
    }
}

TEST_F(Drawing, EmptySurfaceShowsFingers) {
    auto shown = shown_scene("globe", 96, 64);
    const Viewpoint::Subject subject = subject_of(shown->field());
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, std::vector<double>(96 * 64, NAN));
    shown->prev.codes.clear();
    const HeightField field = shown->field();
    const ViewCamera camera = own_view(shown->scene, 192, 128, 1);
    const MarkSizes sizes = mark_sizes(shown->scene, subject.middle);
    const auto fingers = fingers_on(subject, sizes.finger_radius);
    const ViewSurface empty = make_view_surface(field, {});
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        const GpuImage target = target_of(192, 128);
        const Image expected = cpu_picture(*drawing, empty, camera, {}, {});
        EXPECT_EQ(picture_of(*drawing, camera, {}, sizes, target).samples, expected.samples) << painter;
        show(*drawing, field, shown->pair(), {});
        EXPECT_EQ(picture_of(*drawing, camera, {}, sizes, target).samples, expected.samples) << painter;
        EXPECT_GT(different(picture_of(*drawing, camera, fingers, sizes, target), expected, 20), 100U);
    }
}

TEST_F(Drawing, ReusesUploadMemory) {
    UploadPool pool(gpu);
    const auto copy_of = must(GpuBuffer::create(*gpu, "copy", 64, GpuMemory::readback));
    const auto handle_of_next = [&](GpuCommands& commands) {
        const GpuBuffer buffer = must(pool.lease("upload", 64));
        commands.copy(buffer, 0, copy_of, 0, 64);
        return buffer.handle();
    };
    auto first = must(GpuCommands::begin(gpu, "first")), second = must(GpuCommands::begin(gpu, "second"));
    const VkBuffer one = handle_of_next(first), two = handle_of_next(second);
    EXPECT_NE(one, two);
    must(must(std::move(first).submit()).wait());
    auto third = must(GpuCommands::begin(gpu, "third"));
    EXPECT_EQ(handle_of_next(third), one);
    EXPECT_GE(must(pool.lease("larger", 100'000)).bytes(), 100'000U);
}

TEST_F(Drawing, MapsKeepTheirColours) {
    const auto shown = shown_scene("plane", 96, 64);
    const std::vector<std::uint8_t> bytes(96 * 64 * 3, 77);
    const PlaneView map{bytes.data(), 96 * 3, 96, 64, 1, 3};
    for (const char* painter : painters) {
        const auto drawing = drawing_by(painter);
        show(*drawing, shown->field(), shown->pair(), map, Lighting::values);
        const Image drawn =
            picture_of(*drawing, own_view(shown->scene, 96, 64, 1), {}, {}, target_of(96, 64));
        EXPECT_EQ(std::count(drawn.samples.begin(), drawn.samples.end(), 77), 96 * 64 * 3) << painter;
    }
}

/// Frames with heights as a session publishes them, into three slots, and their colours.
struct PublishedClip {
    PublishedClip() : shown(shown_scene("globe", 120, 80)), builder(make_cpu_builder(shown->scene)) {
        shown->scene.height_coding = {0.05 * shown->scene.depth.near, HeightUnits::world, 255};
    }
    SurfaceFrame& publish(std::int64_t n) {
        RawFrame raw = n % 2 == 0 ? shown->raw_prev : shown->raw_next;
        std::vector<std::uint8_t> heights;
        for (std::int64_t k = 0; k < 120 * 80; ++k)
            heights.push_back(static_cast<std::uint8_t>(k * (n + 1) % 251));
        raw.height = {heights.data(), 120, 120, 80};
        raw.storage.reset();
        raw.number = n;
        SurfaceFrame* const slot = timeline.acquire();
        if (slot == nullptr) throw std::runtime_error("no slot is free");
        must(builder->build(raw, *slot));
        must(timeline.publish(n, n * ms));
        return *slot;
    }
    /// Around a time in frames.
    FramePair pair_at(double time) {
        FramePair pair;
        EXPECT_TRUE(timeline.pair_at(static_cast<std::int64_t>(time * ms), pair));
        return pair;
    }

    static constexpr std::int64_t ms = 1'000'000;
    std::unique_ptr<Shown> shown;
    std::unique_ptr<SurfaceBuilder> builder;
    SurfaceTimeline timeline{3};
    ManyColours colours{120, 80};
    std::uint64_t content = new_content_number();  // of the colours
};

/// With a GPU's memory that is the CPU's too, or not. The painter mesh has its lattice made by kernels where
/// Vulkan computes on the CPU, too.
class KeptPlanes : public Drawing, public ::testing::WithParamInterface<bool> {
protected:
    void SetUp() override {
        Drawing::SetUp();
        gpu->vulkan()->facts.unified_memory = GetParam();
        drawing = drawing_by("mesh");
        clip.emplace();
    }
    void TearDown() override {
        drawing.reset();
        Drawing::TearDown();
    }

    void publish_two() {
        clip->publish(0);
        clip->publish(1);
    }
    PlaneView colour() const {
        PlaneView view = clip->colours.view();
        view.content = clip->content;
        return view;
    }
    ViewCamera camera() const { return own_view(clip->shown->scene, 240, 160, 2); }
    Image picture(SurfaceDrawing& by, const FramePair& pair) {
        show(by, HeightField(clip->shown->scene, pair), pair, colour());
        return picture_of(by, camera(), {}, {}, target_of(240, 160));
    }
    /// The picture equals that of a new drawing and of the CPU, and differs from the last.
    void expect_as_anew(const FramePair& pair, const char* what) {
        const auto anew = drawing_by("mesh");
        Image drawn = picture(*drawing, pair);
        EXPECT_EQ(drawn.samples, picture(*anew, pair).samples) << what;
        const HeightField field(clip->shown->scene, pair);
        const Image expected = cpu_picture(*drawing, make_view_surface(field, colour()), camera(), {}, {});
        EXPECT_LE(different(drawn, expected, 3), 60U) << what;
        EXPECT_NE(drawn.samples, last.samples) << what;
        last = std::move(drawn);
    }

    std::optional<PublishedClip> clip;
    std::unique_ptr<SurfaceDrawing> drawing;
    Image last;
};

TEST_P(KeptPlanes, DrawAsNewOnes) {
    publish_two();
    const FramePair first = clip->pair_at(0.3);
    expect_as_anew(first, "the first pair");
    expect_as_anew(clip->pair_at(0.6), "the same pair later");
    expect_as_anew({first.next, first.prev, 0.3}, "its frames swapped");
    expect_as_anew({first.prev, first.prev, 0}, "one of them");

    std::ranges::reverse(clip->colours.bytes);
    clip->content = new_content_number();
    expect_as_anew(first, "colours where others were");
    std::ranges::reverse(clip->colours.bytes);
    clip->content = 0;
    expect_as_anew(first, "colours without a number");
    std::ranges::reverse(clip->colours.bytes);
    expect_as_anew(first, "other colours without a number");

    clip->publish(2);
    clip->pair_at(2);
    clip->publish(3);
    clip->publish(4);
    const FramePair later = clip->pair_at(3.3);
    ASSERT_EQ(later.prev.frame, first.next.frame);
    ASSERT_EQ(later.next.frame, first.prev.frame);
    expect_as_anew(later, "frames where others were");
}

TEST_P(KeptPlanes, AreNotUploadedAgain) {
    SurfaceFrame *const prev = &clip->publish(0), *const next = &clip->publish(1);
    const FramePair pair = clip->pair_at(0.3);
    const Image before = picture(*drawing, pair);
    for (SurfaceFrame* frame : {prev, next}) {
        std::ranges::reverse(frame->heights);
        std::ranges::fill(frame->codes, frame->codes[60 * 120 + 60]);
        std::ranges::fill(frame->validity, 0x77777777U);
    }
    std::ranges::reverse(clip->colours.bytes);
    EXPECT_EQ(picture(*drawing, pair).samples, before.samples);
    prev->content = next->content = 0;
    clip->content = new_content_number();
    EXPECT_GT(different(picture(*drawing, pair), before, 3), 5000U);
}

TEST_P(KeptPlanes, ExcludeUnpublishedFrames) {
    Shown& shown = *clip->shown;
    for (SurfaceFrame* frame : {&shown.prev, &shown.next}) frame->heights.assign(120 * 80, 7);
    expect_as_anew(shown.pair(0.3), "heights");
    std::ranges::fill(shown.next.heights, std::uint16_t{240});
    expect_as_anew(shown.pair(0.3), "other heights");
}

TEST_P(KeptPlanes, ExcludeDiscardedCommands) {
    publish_two();
    const FramePair pair = clip->pair_at(0.3);
    {
        auto forgotten = must(GpuCommands::begin(gpu, "forgotten"));
        must(drawing->show(forgotten, HeightField(clip->shown->scene, pair), pair, colour(), Lighting::full));
    }
    expect_as_anew(pair, "for the first time");
}

/// Each program took half a second on a GPU.
TEST_P(KeptPlanes, KeepTheirPrograms) {
    publish_two();
    const FramePair still = clip->pair_at(0);
    show(*drawing, HeightField(clip->shown->scene, still), still, {});
    picture_of(*drawing, camera(), {}, {}, target_of(240, 160));
    gpu->vulkan()->facts.limits.max_push_constants = 0;  // refuses every program
    EXPECT_FALSE(SurfaceDrawing::create(gpu, "mesh"));
    const FramePair pair = clip->pair_at(0.3);
    const HeightField field(clip->shown->scene, pair);
    show(*drawing, field, pair, colour());
    const ViewCamera turned = view_of(*clip->shown, field, "orbit:az=25,el=10", 240, 160);
    picture_of(*drawing, turned, {}, {}, target_of(240, 160));
}

INSTANTIATE_TEST_SUITE_P(Drawing, KeptPlanes, ::testing::Bool(), [](const auto& unified) {
    return std::string(unified.param ? "UnifiedMemory" : "OwnMemory");
});

TEST_F(Drawing, RejectsInvalid) {
    const auto named = SurfaceDrawing::create(gpu, "oil");
    ASSERT_FALSE(named);
    EXPECT_EQ(named.error().kind, ErrorKind::usage);
    const auto drawing = drawing_by("auto");
    const auto shown = shown_scene("plane", 32, 32);
    auto commands = must(GpuCommands::begin(gpu, "wrong"));
    const auto wrong = drawing->draw(commands, own_view(shown->scene, 32, 32, 1), {}, {}, target_of(32, 31));
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().kind, ErrorKind::internal);
}

/// A software Vulkan that says it is a graphics card.
TEST(PainterRace, DecidesWhichPainterAutoIs) {
    const TemporaryFolder folder;
    GpuOptions options;
    options.cache_folder = folder.path();
    const auto device = must(GpuDevice::open(options));
    GpuFacts& facts = device->vulkan()->facts;
    facts.kind = GpuKind::software;
    measure_painters(device);
    EXPECT_LT(facts.measured.mesh_ms, 0) << "a software Vulkan is not measured";
    EXPECT_EQ(usual_painter(facts), "cpu");
    facts.kind = GpuKind::discrete;
    EXPECT_EQ(usual_painter(facts), "mesh");
    measure_painters(device);
    for (const double ms : {facts.measured.mesh_ms, facts.measured.raster_ms}) {
        EXPECT_GT(ms, 0);
        EXPECT_LT(ms, 60'000);
    }
    EXPECT_EQ(must(SurfaceDrawing::create(device, "auto"))->painter(),
              facts.measured.mesh_ms <= facts.measured.raster_ms ? "mesh" : "raster");
    const GpuFacts::Measured first = facts.measured;
    measure_painters(device);
    EXPECT_EQ(facts.measured.mesh_ms, first.mesh_ms) << "once";
    facts.measured = {.mesh_ms = 1, .raster_ms = HUGE_VAL};
    EXPECT_EQ(usual_painter(facts), "mesh") << "the other one has lost the device";
    facts.measured = {.mesh_ms = HUGE_VAL, .raster_ms = -1};
    EXPECT_EQ(usual_painter(facts), "raster");
    facts.int64_atomics = false;
    EXPECT_EQ(usual_painter(facts), "mesh");
    facts.draws_triangles = false;
    EXPECT_EQ(usual_painter(facts), "raster");
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

TEST(CutRule, CutsInvalidCorner) {
    EXPECT_TRUE(triangle_is_cut(0, 0, 0));
    for (const auto& [a, b, c] : {std::array{0.0F, 1.0F, 1.0F}, {1.0F, 0.0F, 1.0F}, {1.0F, 1.0F, 0.0F}})
        EXPECT_TRUE(triangle_is_cut(a, b, c) && triangle_has_hole(a, b, c));
    EXPECT_FALSE(triangle_has_hole(1, 0.01F, 100)) << "the clip's own view cuts only holes";
}

/// docs/play.md says so.
TEST(CutRule, AllowsSixPercent) {
    const float most = 1.06F * 0.01F;
    EXPECT_FALSE(triangle_is_cut(0.01F, most, 0.0105F));
    EXPECT_TRUE(triangle_is_cut(0.01F, std::nextafter(most, 1.0F), 0.0105F));
}

TEST(CutRule, CornerOrderDoesNotMatter) {
    for (const auto& corners : {std::array{1.0F, 1.03F, 1.059F}, std::array{1.0F, 1.03F, 1.061F}}) {
        std::array<int, 3> order{0, 1, 2};
        const bool expected = triangle_is_cut(corners[0], corners[1], corners[2]);
        do {
            auto q = [&](std::size_t k) { return corners[static_cast<std::size_t>(order[k])]; };
            EXPECT_EQ(triangle_is_cut(q(0), q(1), q(2)), expected);
        } while (std::next_permutation(order.begin(), order.end()));
    }
}

TEST(CutRule, ScaleDoesNotMatter) {
    for (const float scale : {1e-6F, 1.0F, 1e6F}) {
        EXPECT_FALSE(triangle_is_cut(scale, 1.05F * scale, scale));
        EXPECT_TRUE(triangle_is_cut(scale, 1.07F * scale, scale));
    }
}

}  // namespace
}  // namespace touchable

namespace touchable::test {
namespace {

/// Where a vertex of the decimated lattice is in the whole one.
int whole_at(int n, int step, int vertices) {
    return std::min(n * step, vertices - 1);
}

/// One vertex after the other.
void expect_every(const Shown& shown, double blend, int step, VectorUnit unit) {
    const HeightField whole = shown.field(blend);
    const FramePair pair = shown.pair(blend);
    ASSERT_TRUE(SurfaceUnproject::has_codes(whole, pair));
    Decimation decimation(2, unit);
    decimation.make(whole, pair, {}, step);
    const HeightField& part = decimation.field();
    ASSERT_GE((part.width() - 1) * step, whole.width() - 1) << "nothing is missing at the right";
    ASSERT_GE((part.height() - 1) * step, whole.height() - 1);
    ASSERT_LT((part.width() - 2) * step, whole.width() - 1) << "and nothing is there twice";
    EXPECT_EQ(part.blend(), whole.blend());
    int valid = 0;
    for (int y = 0; y < part.height(); ++y)
        for (int x = 0; x < part.width(); ++x) {
            const int at_x = whole_at(x, step, whole.width()), at_y = whole_at(y, step, whole.height());
            const FieldVertex wanted = whole.vertex(at_x, at_y), is = part.vertex(x, y);
            ASSERT_EQ(is.valid, wanted.valid) << x << ", " << y;
            if (!is.valid) continue;
            ASSERT_EQ(is.depth, wanted.depth) << x << ", " << y;
            ++valid;
            if (at_x == x * step) {
                ASSERT_NEAR(part.scene().camera.u(x), whole.scene().camera.u(at_x), 1e-12);
            }
        }
    EXPECT_GT(valid, 20);
}

TEST(Decimation, KeepsEveryNthVertex) {
    for (const auto& [width, height] : {std::pair{172, 133}, {65, 34}, {127, 128}})
        for (const char* scene : {"globe", "noise", "grain"}) {
            SCOPED_TRACE(std::string(scene) + " " + std::to_string(width));
            const auto shown = shown_scene(scene, width, height);
            for (const VectorUnit unit : usable_vector_units())
                for (const int step : {2, 4, 8}) expect_every(*shown, step == 4 ? 0.25 : 0, step, unit);
        }
}

TEST(Decimation, KeepsHolesAndHeights) {
    for (const char* recording : {"castel_sr300", "redwood5"}) {
        const auto shown = shown_stand_in(recording);
        ASSERT_NE(shown, nullptr);
        for (const int step : {2, 4}) expect_every(*shown, 0.5, step, usable_vector_units().front());
    }
}

void expect_means(int width, int height, int threads, VectorUnit unit) {
    const auto shown = shown_scene("globe", width, height);
    const ManyColours colours(width, height);
    const PlaneView from = colours.view();
    Decimation decimation(threads, unit);
    decimation.make(shown->field(), shown->pair(), from, 2);
    const PlaneView& half = decimation.colour();
    ASSERT_EQ(half.width, decimation.field().width());
    ASSERT_EQ(half.height, decimation.field().height());
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
            for (int channel = 0; channel < 3; ++channel) {
                int sum = 0;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        sum += (2 - std::abs(dx)) * (2 - std::abs(dy)) *
                               from.sample(std::clamp(2 * x + dx, 0, width - 1),
                                           std::clamp(2 * y + dy, 0, height - 1), channel);
                ASSERT_EQ(half.sample(x, y, channel), (sum + 8) / 16) << x << ", " << y;
            }
    decimation.make(shown->field(), shown->pair(), from, 4);
    EXPECT_EQ(decimation.colour().width, decimation.field().width());
    EXPECT_EQ(decimation.colour().height, decimation.field().height());
}

TEST(Decimation, MeansColoursAroundEachVertex) {
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 2})
            for (const auto& [width, height] : {std::pair{37, 22}, {130, 71}})
                expect_means(width, height, threads, unit);
}

TEST(Decimation, StepFollowsPixelsPerVertex) {
    EXPECT_EQ(SurfaceDrawing::step_for(1280.0 / 720), 1);
    EXPECT_EQ(SurfaceDrawing::step_for(0.76), 1);
    EXPECT_EQ(SurfaceDrawing::step_for(1280.0 / 1920), 2);
    EXPECT_EQ(SurfaceDrawing::step_for(0.5), 2);
    EXPECT_EQ(SurfaceDrawing::step_for(0.3), 4);
    EXPECT_EQ(SurfaceDrawing::step_for(1e-9), 8);
}

TEST(Decimation, KeepsViewpoint) {
    const auto shown = shown_scene("globe", 64, 48);
    const ViewCamera camera =
        make_view(*parse_viewpoint("orbit:az=30,el=10"), shown->scene, {0, 0, -0.7}, 320, 200);
    const ViewCamera coarse = decimated(camera, 4);
    for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(12, 7)}) {
        const glm::dvec4 one = camera.clip_from_lattice * glm::dvec4(4.0 * at, 1, 2),
                         other = coarse.clip_from_lattice * glm::dvec4(at, 1, 2);
        for (int k = 0; k < 4; ++k) EXPECT_NEAR(one[k], other[k], 1e-9);
    }
}

TEST(DoubledPicture, MatchesExactLinearFilter) {
    for (const auto& size : {std::pair{1, 1}, {2, 3}, {37, 5}, {160, 4}}) {
        const int width = size.first, height = size.second;
        std::vector<PackedColour> from(pixel_count(width, height)), to(4 * from.size());
        std::uint32_t state = 1;
        for (PackedColour& pixel : from) pixel = state = state * 1664525U + 1013904223U;
        double_picture(from, width, height, to);
        for (int y = 0; y < 2 * height; ++y)
            for (int x = 0; x < 2 * width; ++x)
                for (const int shift : {0, 8, 16, 24}) {
                    const auto sample = [&](int right, int down) {
                        const int column = std::clamp(x / 2 + right * (x % 2 * 2 - 1), 0, width - 1),
                                  row = std::clamp(y / 2 + down * (y % 2 * 2 - 1), 0, height - 1);
                        return from[static_cast<std::size_t>(row * width + column)] >> shift & 255U;
                    };
                    ASSERT_EQ(to[static_cast<std::size_t>(y * 2 * width + x)] >> shift & 255U,
                              (9 * sample(0, 0) + 3 * (sample(1, 0) + sample(0, 1)) + sample(1, 1) + 8) / 16)
                        << width << ": " << x << ", " << y;
                }
    }
}

}  // namespace
}  // namespace touchable::test
