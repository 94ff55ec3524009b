// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/drawing_race.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "bench/clocks.hpp"
#include "bench/surface/race.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/base/try.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"

namespace touchable {
namespace {

struct PictureSize {
    int width = 1280, height = 720;
};

/// Two consecutive frames of a clip.
struct TwoFrames {
    Scene scene;
    RawFrame first, second;
};

Result<TwoFrames> planet_frames() {
    SceneOptions options;
    options.properties = true;
    auto globe = make_scene("globe", options);
    if (!globe) return globe.error();
    return TwoFrames{(*globe)->scene(), (*globe)->frame(0), (*globe)->frame(1)};
}

/// Two frames that differ in every pixel.
Result<TwoFrames> moving_frames(const PictureSize& size) {
    SceneOptions options;
    options.width = size.width;
    options.height = size.height;
    TRY_ASSIGN(const auto moving, make_scene("moving", options));
    return TwoFrames{moving->scene(), moving->frame(0), moving->frame(1)};
}

Result<TwoFrames> recorded_frames(const std::filesystem::path& clip) {
    auto reader =
        open_clip(clip, std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/castel_sr300.json");
    if (!reader) return reader.error();
    TwoFrames frames{(*reader)->scene(), {}, {}};
    for (RawFrame* frame : {&frames.first, &frames.second}) {
        auto next = (*reader)->next();
        if (!next) return next.error();
        if (!*next) return Error{ErrorKind::check, clip.string() + " has fewer than two frames"};
        *frame = std::move(**next);
    }
    return frames;
}

std::vector<FingerMark> five_fingers(const Viewpoint::Subject& subject, double size) {
    std::vector<FingerMark> fingers(5);
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        FingerMark& finger = fingers[k];
        finger.proxy = subject.points[subject.points.size() * (k + 1) / 6];
        finger.goal = finger.proxy - glm::dvec3(0, 0, 2 * size);
        finger.touching = true;
        finger.force = {0.2, 0.3, 1};
        for (int n = 0; n < 125; ++n)
            finger.trail.push_back(finger.proxy + glm::dvec3(0.05 * size * (n - 124), 0, 0.2 * size));
    }
    return fingers;
}

/// One surface, two views of it, and pictures of it by several painters in turn.
class Gallery {
public:
    Gallery(TwoFrames frames, std::shared_ptr<GpuDevice> device, PictureSize size = {})
        : frames_(std::move(frames)), device_(std::move(device)), size_(size) {}

    const Scene& scene() const { return frames_.scene; }

    Result<void> open(SurfaceBuilder& builder) {
        for (const auto& [raw, frame] : {std::pair{&frames_.first, &prev_}, {&frames_.second, &next_}})
            if (auto built = builder.build(*raw, *frame); !built) return built;
        field_.emplace(frames_.scene, pair());
        subject_ = subject_of(*field_);
        sizes_ = mark_sizes(frames_.scene, subject_.middle);
        fingers_ = five_fingers(subject_, sizes_.finger_radius);
        dented_ = fingers_;
        for (FingerMark& finger : dented_) {
            finger.under = under_finger(*field_, finger.proxy, sizes_.finger_radius);
            finger.given_way = (finger.goal - finger.proxy) / 2.0;
        }
        for (const double azimuth : {20.0, 20.1})
            views_.push_back(make_view({false, azimuth, 8, 1, std::nullopt}, frames_.scene, subject_.middle,
                                       size_.width, size_.height));
        auto target =
            GpuImage::create(*device_, "picture", size_.width, size_.height, VK_FORMAT_R8G8B8A8_UNORM);
        if (!target) return target.error();
        target_ = std::move(*target);
        return {};
    }

    Result<void> show(SurfaceDrawing& drawing) const {
        return submit([&](GpuCommands& commands) {
            return drawing.show(commands, *field_, pair(), frames_.first.colour, Lighting::full);
        });
    }
    /// Draws; `moves`: from the other viewpoint than last time.
    Result<void> draw(SurfaceDrawing& drawing, bool moves) {
        view_ = moves ? 1 - view_ : view_;
        return submit([&](GpuCommands& commands) {
            return drawing.draw(commands, views_[view_], fingers_, sizes_, target_);
        });
    }
    /// Builds the two frames alternately, as the pair's later frame.
    Result<void> build_next(SurfaceBuilder& builder) {
        builds_second_ = !builds_second_;
        return builder.build(builds_second_ ? frames_.second : frames_.first, next_);
    }
    /// Shows the surface and draws it from the other viewpoint than last time, in one submission.
    Result<void> show_and_draw(SurfaceDrawing& drawing) {
        view_ = 1 - view_;
        return submit([&](GpuCommands& commands) -> Result<void> {
            TRY(drawing.show(commands, *field_, pair(), frames_.first.colour, Lighting::full));
            return drawing.draw(commands, views_[view_], fingers_, sizes_, target_);
        });
    }
    /// Draws with a dent in the surface under every finger.
    Result<void> draw_dented(SurfaceDrawing& drawing) {
        return submit([&](GpuCommands& commands) {
            return drawing.draw(commands, views_[view_], dented_, sizes_, target_);
        });
    }
    /// The steps for a picture in a file: the surface, then painted and composed with one sample per pixel.
    Result<void> make_surface() {
        surface_ = surface_of(*field_, pair(), frames_.first.colour, Lighting::full);
        return {};
    }
    Result<void> put_together(SurfacePainter& painter) {
        auto planes = painter.paint(surface_, views_[view_]);
        if (!planes) return planes.error();
        LightPicture picture = on_background(std::move(*planes));
        draw_fingers(fingers_, sizes_, views_[view_], picture);
        picture_ = developed(picture, 1);
        return {};
    }
    Result<void> make_file_picture(SurfacePainter& painter) const {
        const SurfacePainter::Settings settings{{false, 20, 8, 1, std::nullopt}, size_.width, size_.height};
        const auto made =
            make_picture(settings, frames_.scene, surface_, subject_, fingers_, sizes_, painter);
        if (!made) return made.error();
        return {};
    }

    /// Compares the target's picture with that of the CPU from the same view. Edges of fingers may differ.
    Result<void> compare(const std::string& painter) const {
        auto back = GpuBuffer::create(*device_, "picture", 4 * pixel_count(size_.width, size_.height),
                                      GpuMemory::readback);
        if (!back) return back.error();
        auto copied = submit([&](GpuCommands& commands) -> Result<void> {
            record_transition(commands, target_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                              VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
            VkBufferImageCopy region{};
            region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
            region.imageExtent = {static_cast<std::uint32_t>(size_.width),
                                  static_cast<std::uint32_t>(size_.height), 1};
            vkCmdCopyImageToBuffer(commands.handle(), target_.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                   back->handle(), 1, &region);
            commands.keep(back->keep_alive());
            return {};
        });
        if (!copied) return copied;
        const auto bytes = back->mapped<std::uint8_t>();
        std::size_t different = 0;
        for (std::size_t k = 0; 3 * k < picture_.samples.size(); ++k)
            for (std::size_t channel = 0; channel < 3; ++channel)
                if (std::abs(bytes[4 * k + channel] - picture_.samples[3 * k + channel]) > 12) {
                    ++different;
                    break;
                }
        if (different > picture_.samples.size() / 3 / 100)
            return Error{ErrorKind::check, std::to_string(different) + " pixels by " + painter +
                                               " are not as the CPU puts them together"};
        return {};
    }

private:
    FramePair pair() const { return {{0, 0, &prev_}, {1, 33'333'333, &next_}, 0.35}; }

    Result<void> submit(const std::function<Result<void>(GpuCommands&)>& record) const {
        auto commands = GpuCommands::begin(device_, "picture");
        if (!commands) return commands.error();
        if (auto recorded = record(*commands); !recorded) return recorded;
        const auto submission = std::move(*commands).submit();
        if (!submission) return submission.error();
        return submission->wait();
    }

    TwoFrames frames_;
    std::shared_ptr<GpuDevice> device_;
    const PictureSize size_;
    SurfaceFrame prev_, next_;
    bool builds_second_ = true;  // the frame in `next_`
    std::optional<HeightField> field_;
    Viewpoint::Subject subject_;
    MarkSizes sizes_;
    std::vector<FingerMark> fingers_, dented_;
    std::vector<ViewCamera> views_;
    std::size_t view_ = 0;
    GpuImage target_;
    ViewSurface surface_;
    Image picture_;
};

Result<void> measure_pictures(Result<TwoFrames> frames, int rounds,
                              const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    if (!frames) return frames.error();
    const auto& device = kernels->device();
    Gallery gallery(std::move(*frames), device);
    TRY_ASSIGN(const auto builder, make_vulkan_builder(gallery.scene(), kernels, plan_for(device->facts())));
    if (auto opened = gallery.open(*builder); !opened) return opened;
    const auto painter = make_raster_painter(device);
    if (!painter) return painter.error();
    std::vector<Racer> racers{
        {"file_surface", [&] { return gallery.make_surface(); }},
        {"file_paint", [&] { return gallery.put_together(**painter); }},
    };
    std::vector<std::unique_ptr<SurfaceDrawing>> drawings;
    for (const char* name : {"cpu", "raster", "mesh"}) {
        auto made = SurfaceDrawing::create(device, name);
        if (!made) return made.error();
        SurfaceDrawing& drawing = **made;
        drawings.push_back(std::move(*made));
        const std::string suffix = drawing.painter() == "raster" ? "" : "_" + std::string(drawing.painter());
        racers.push_back({"show" + suffix, [&] { return gallery.show(drawing); }});
        racers.push_back({"draw" + suffix, [&] { return gallery.draw(drawing, true); }});
        racers.push_back({"draw_fingers" + suffix, [&] { return gallery.draw(drawing, false); }});
        racers.push_back({"draw_dents" + suffix, [&] { return gallery.draw_dented(drawing); }});
    }
    for (const auto& drawing : drawings) {
        for (const auto& done :
             {gallery.show(*drawing), gallery.draw(*drawing, true), gallery.make_surface(),
              gallery.put_together(**painter), gallery.compare(std::string(drawing->painter()))})
            if (!done) return done;
    }
    if (auto raced = race(racers, rounds); !raced) return raced;
    std::vector<Racer> files{{"file_picture", [&] { return gallery.make_file_picture(**painter); }}};
    if (auto raced = race(files, std::max(1, rounds / 10)); !raced) return raced;
    racers.push_back(files.front());
    for (const Racer& racer : racers) add_times(figures, racer.name, racer.times);
    return {};
}

/// Measures pictures of this builder's frames with each GPU painter.
Result<void> measure_pictures_of(SurfaceBuilder& builder, Gallery& gallery, const std::string& name,
                                 double seconds, const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    TRY(gallery.open(builder));
    const auto painter = make_cpu_painter();
    std::vector<std::unique_ptr<SurfaceDrawing>> drawings;
    std::vector<Racer> racers;
    for (const char* by : {"cpu", "raster", "mesh"}) {
        auto made = SurfaceDrawing::create(device, by);
        if (!made && made.error().kind == ErrorKind::gpu) continue;  // the device lacks what it needs
        if (!made) return made.error();
        SurfaceDrawing& drawing = *drawings.emplace_back(std::move(*made));
        TRY(gallery.show(drawing));
        TRY(gallery.draw(drawing, true));
        TRY(gallery.make_surface());
        TRY(gallery.put_together(*painter));
        TRY(gallery.compare(by));
        const std::string what = by + ("_" + name);
        racers.push_back({what, [&] { return gallery.show_and_draw(drawing); }});
        racers.push_back({what + "_frame", [&]() -> Result<void> {
                              TRY(gallery.build_next(builder));
                              return gallery.show_and_draw(drawing);
                          }});
    }
    TRY(race(racers, 1));
    const std::int64_t end = monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9);
    do {
        TRY(race(racers, 1));
    } while (monotonic_ns() < end);
    for (const Racer& racer : racers) add_times(figures, racer.name, racer.times);
    return {};
}

}  // namespace

Result<void> measure_pictures_by_builder(int width, int height, double seconds,
                                         const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    const auto& device = kernels->device();
    TRY_ASSIGN(auto frames, moving_frames({width, height}));
    Gallery gallery(std::move(frames), device, {width, height});
    const auto by_cpu = make_cpu_builder(gallery.scene());
    TRY(measure_pictures_of(*by_cpu, gallery, "cpu", seconds, device, figures));
    TRY_ASSIGN(const auto by_vulkan,
               make_vulkan_builder(gallery.scene(), kernels, plan_for(device->facts())));
    return measure_pictures_of(*by_vulkan, gallery, "vulkan", seconds, device, figures);
}

std::vector<BenchCase> drawing_cases(
    bool quick, const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels) {
    const int rounds = quick ? 10 : 100;
    const auto with = [kernels, rounds](const std::function<Result<TwoFrames>()>& frames) {
        return [kernels, rounds, frames](Figures& figures) -> Result<void> {
            auto taken = kernels();
            if (!taken) return taken.error();
            return measure_pictures(frames(), rounds, *taken, figures);
        };
    };
    std::vector<BenchCase> cases{{"720x480-globe-pictures", with(planet_frames)}};
    const std::filesystem::path castel = std::filesystem::path(TOUCHABLE_TEST_DATA) / "castel_sr300";
    if (std::filesystem::exists(castel))
        cases.push_back({"640x480-castel-pictures", with([castel] { return recorded_frames(castel); })});
    else
        std::fprintf(stderr, "case 640x480-castel-pictures is left out: no recording at %s\n",
                     castel.c_str());
    return cases;
}

}  // namespace touchable
