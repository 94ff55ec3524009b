#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "bench/media/codec_run.hpp"
#include "bench/media/force_loss.hpp"
#include "bench/media/plane_sequence.hpp"
#include "bench/suite.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Caches one source's pictures and their size as FFV1.
class PictureShelf {
public:
    struct Entry {
        std::vector<RawFrame> frames;
        std::map<PlaneRole, double> ffv1_bytes;
    };
    Result<Entry*> take(const PictureSource& source) {
        if (name_ == source.name) return &entry_;
        name_.clear();
        entry_ = {};  // frees memory first
        TRY_ASSIGN(auto made, source.make());
        entry_.frames = std::move(made);
        name_ = source.name;
        return &entry_;
    }
    /// Bytes of a frame's plane, by the first of codec_choices.
    static Result<double> ffv1_bytes(Entry& entry, PlaneRole role, const std::vector<PlaneView>& planes) {
        if (const auto known = entry.ffv1_bytes.find(role); known != entry.ffv1_bytes.end())
            return known->second;
        auto bytes = bytes_per_frame(codec_choices(role, planes.front()).front(), planes);
        if (bytes) entry.ffv1_bytes[role] = *bytes;
        return bytes;
    }

private:
    std::string name_;
    Entry entry_;
};

/// Caches one clip, touched when it is first needed.
class FeltShelf {
public:
    Result<const FeltClip*> take(const FeltSource& source) {
        if (name_ == source.name) return &clip_;
        name_.clear();
        clip_ = {};  // frees memory first
        TRY_ASSIGN(auto made, source.make());
        clip_ = std::move(made);
        name_ = source.name;
        return &clip_;
    }

private:
    std::string name_;
    FeltClip clip_;
};

/// Adds cases of the force error of each way to send a plane.
void add_force_cases(std::vector<BenchCase>& cases) {
    const auto shelf = std::make_shared<FeltShelf>();
    for (const FeltSource& source : felt_sources())
        for (const PlaneRole role : source.planes)
            for (const CodecChoice& choice : sent_choices(role, source.name.starts_with("materials"))) {
                const std::string name =
                    "force-" + source.name + "-" + std::string(role_name(role)) + "-" + choice.name;
                cases.push_back({name, [=](Figures& figures) -> Result<void> {
                                     TRY_ASSIGN(const auto clip, shelf->take(source));
                                     return measure_force_loss(*clip, role, choice, figures);
                                 }});
            }
}

/// The form of a source's planes before they are made, used only to list the codecs.
PlaneView form_of(PlaneRole role, const PictureSource& source) {
    PlaneView form;
    form.width = form.height = 2;
    if (role == PlaneRole::colour || role == PlaneRole::haptic) form.channels = 3;
    if (role == PlaneRole::depth && source.name.ends_with("-16")) form.bytes_per_sample = 2;
    return form;
}

Result<void> measure_plane(const PictureSource& source, PlaneRole role, std::size_t choice, bool quick,
                           PictureShelf& shelf, Figures& figures) {
    TRY_ASSIGN(const auto entry, shelf.take(source));
    const std::vector<PlaneView> planes = planes_of(entry->frames, role);
    TRY_ASSIGN(const auto ffv1, PictureShelf::ffv1_bytes(*entry, role, planes));
    return measure_codec(codec_choices(role, planes.front())[choice], planes, ffv1, quick ? 2 : 5, figures);
}

std::optional<double> value_of(const CaseFigures& c, const char* metric) {
    const auto found = std::ranges::find(c.figures, metric, &Figure::metric);
    return found == c.figures.end() ? std::nullopt : std::optional(found->value);
}

/// "globe-1920x1080-16-depth" of "globe-1920x1080-16-depth-ffv1-range".
std::string plane_in(const std::string& name) {
    for (const PlaneRole role : all_roles) {
        const std::string part = "-" + std::string(role_name(role)) + "-";
        if (const auto at = name.find(part); at != std::string::npos)
            return name.substr(0, at + part.size() - 1);
    }
    return name;
}

struct PlaneWinner {
    std::string codec = "-";
    double value = 0, other = 0;
};
/// The codec with the least value of a metric, among those with at most twice FFV1's bytes.
PlaneWinner least(const std::vector<const CaseFigures*>& of, const std::string& plane, const char* metric,
                  const char* other) {
    PlaneWinner winner;
    for (const CaseFigures* c : of) {
        const auto value = value_of(*c, metric);
        if (!value || value_of(*c, "vs_ffv1").value_or(0) > 2 ||
            (winner.codec != "-" && *value >= winner.value))
            continue;
        winner = {c->name.substr(plane.size() + 1), *value, value_of(*c, other).value_or(0)};
    }
    return winner;
}

}  // namespace

std::vector<BenchCase> media_cases(bool quick) {
    const auto shelf = std::make_shared<PictureShelf>();
    std::vector<BenchCase> cases;
    for (const PictureSource& source : picture_sources(quick))
        for (const PlaneRole role : source.planes) {
            const auto choices = codec_choices(role, form_of(role, source));
            for (std::size_t n = 0; n < choices.size(); ++n) {
                const std::string name =
                    source.name + "-" + std::string(role_name(role)) + "-" + choices[n].name;
                cases.push_back({name, [=](Figures& figures) -> Result<void> {
                                     auto done = measure_plane(source, role, n, quick, *shelf, figures);
                                     if (done) return done;
                                     return Error{done.error().kind, name + ": " + done.error().message};
                                 }});
            }
        }
    add_force_cases(cases);
    return cases;
}

Result<void> conclude_media(const std::vector<CaseFigures>& measured) {
    // Lossless codecs readable by any program: without lossy colour and our own codecs.
    std::map<std::string, std::vector<const CaseFigures*>> planes;
    std::vector<std::string> order;
    for (const CaseFigures& c : measured) {
        if (value_of(c, "psnr_db") || value_of(c, "largest_change")) continue;
        const auto by = [&](const char* codec) { return c.name.find(codec) != std::string::npos; };
        const bool by_ffmpeg = by("-ffv") || by("-png") || by("-magicyuv") || by("-h264");
        const std::string plane = plane_in(c.name);
        if (!by_ffmpeg || plane == c.name) continue;
        if (!planes.contains(plane)) order.push_back(plane);
        planes[plane].push_back(&c);
    }
    std::size_t width = 0;
    for (const std::string& plane : order) width = std::max(width, plane.size());
    std::printf(
        "\nLossless, of what FFmpeg reads and what needs at most twice the bytes of FFV1:\n\n%-*s  %-14s %9s "
        "%8s  %-14s %8s %9s\n",
        static_cast<int>(width), "", "least decoding", "decode_ms", "vs_ffv1", "fewest bytes", "vs_ffv1",
        "decode_ms");
    for (const std::string& plane : order) {
        const PlaneWinner fast = least(planes[plane], plane, "decode_ms", "vs_ffv1");
        const PlaneWinner small = least(planes[plane], plane, "vs_ffv1", "decode_ms");
        std::printf("%-*s  %-14s %9.2f %8.3f  %-14s %8.3f %9.2f\n", static_cast<int>(width), plane.c_str(),
                    fast.codec.c_str(), fast.value, fast.other, small.codec.c_str(), small.value,
                    small.other);
    }
    std::fflush(stdout);
    return {};
}

}  // namespace touchable
