#include "bench/surface/ffmpeg_median.hpp"

#ifdef TOUCHABLE_HAS_AVFILTER

extern "C" {
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavutil/frame.h>
}

#include <cstring>
#include <memory>
#include <string>

#include "bench/surface/race.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

struct Free {
    void operator()(AVFilterGraph* graph) const { avfilter_graph_free(&graph); }
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
using Graph = std::unique_ptr<AVFilterGraph, Free>;
using Frame = std::unique_ptr<AVFrame, Free>;

Error failed(const char* what) {
    return {ErrorKind::internal, std::string("libavfilter: ") + what + " failed"};
}

/// buffer -> median -> buffersink.
class MedianGraph {
public:
    Result<void> open(const PlaneView& plane, int side) {
        plane_ = plane;
        graph_.reset(avfilter_graph_alloc());
        input_.reset(av_frame_alloc());
        output_.reset(av_frame_alloc());
        if (!graph_ || !input_ || !output_) return failed("an allocation");
        const std::string source =
            "video_size=" + std::to_string(plane.width) + "x" + std::to_string(plane.height) +
            ":time_base=1/30:pix_fmt=" + (plane.bytes_per_sample == 2 ? "gray16le" : "gray");
        const std::string radius = "radius=" + std::to_string(side / 2);
        AVFilterContext* median = nullptr;
        if (add(&source_, "buffer", source.c_str()) < 0 || add(&median, "median", radius.c_str()) < 0 ||
            add(&sink_, "buffersink", nullptr) < 0 || avfilter_link(source_, 0, median, 0) < 0 ||
            avfilter_link(median, 0, sink_, 0) < 0 || avfilter_graph_config(graph_.get(), nullptr) < 0)
            return failed("making a graph");
        input_->width = plane.width;
        input_->height = plane.height;
        input_->format = plane.bytes_per_sample == 2 ? AV_PIX_FMT_GRAY16LE : AV_PIX_FMT_GRAY8;
        if (av_frame_get_buffer(input_.get(), 0) < 0) return failed("a frame's buffer");
        for (int y = 0; y < plane.height; ++y)
            std::memcpy(input_->data[0] + std::ptrdiff_t{input_->linesize[0]} * y, plane.row(y),
                        static_cast<std::size_t>(plane.width * plane.bytes_per_sample));
        return {};
    }
    Result<void> filter() {
        av_frame_unref(output_.get());
        ++input_->pts;
        if (av_buffersrc_add_frame_flags(source_, input_.get(), AV_BUFFERSRC_FLAG_KEEP_REF) < 0 ||
            av_buffersink_get_frame(sink_, output_.get()) < 0)
            return failed("filtering a frame");
        return {};
    }
    PlaneView filtered() const {
        return {output_->data[0], output_->linesize[0],    plane_.width,
                plane_.height,    plane_.bytes_per_sample, 1};
    }

private:
    int add(AVFilterContext** context, const char* filter, const char* arguments) {
        return avfilter_graph_create_filter(context, avfilter_get_by_name(filter), filter, arguments, nullptr,
                                            graph_.get());
    }

    PlaneView plane_;
    Graph graph_;
    AVFilterContext *source_ = nullptr, *sink_ = nullptr;  // owned by the graph
    Frame input_, output_;
};

}  // namespace

Result<void> measure_ffmpeg_median(const SurfaceCase& c, const Picture& picture, int frames,
                                   Figures& figures) {
    SurfaceFrame expected;
    if (auto built = make_cpu_builder(picture.scene)->build(picture.raw, expected); !built) return built;
    MedianGraph median;
    if (auto opened = median.open(picture.raw.depth, picture.scene.filter.median); !opened) return opened;
    if (auto filtered = median.filter(); !filtered) return filtered;
    for (int y = 0; y < c.height; ++y)
        for (int x = 0; x < c.width; ++x)
            if (median.filtered().sample(x, y) != expected.codes[expected.index(x, y)])
                return wrong(c, "FFmpeg's median differs at " + std::to_string(x) + ", " + std::to_string(y));
    std::vector<Racer> racers{
        {"ffmpeg_median" + std::to_string(picture.scene.filter.median), [&] { return median.filter(); }}};
    if (auto timed = race(racers, frames); !timed) return timed;
    add_times(figures, racers[0].name, racers[0].times);
    return {};
}

}  // namespace touchable

#else

namespace touchable {

Result<void> measure_ffmpeg_median(const SurfaceCase&, const Picture&, int, Figures&) {
    return {};
}

}  // namespace touchable

#endif
