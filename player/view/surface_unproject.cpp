#include "player/view/surface_unproject.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "player/view/group_rows.hpp"
#include "player/view/view_surface.hpp"
#include "shaders/unproject.h"
#include "shaders/unproject.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(UnprojectPush) == 60);

/// Length = base + step m of a coding, and how m comes from the code; see shaders/unproject.h.
void set_coding(const DepthCoding& coding, UnprojectPush& push) {
    const bool is_inverse = coding.kind == DepthCodingKind::inverse;
    double base = 0, step = coding.scale;  // metric
    // m counts from the near plane, or from the far one where it is 1 / depth that grows.
    bool from_top = false;
    if (is_inverse) {
        base = 1.0 / coding.far;
        step = (1.0 / coding.near - 1.0 / coding.far) / coding.code_max;
        from_top = !coding.near_is_high;
    } else if (coding.kind != DepthCodingKind::metric) {
        base = coding.near;
        step = (coding.far - coding.near) / coding.code_max;
        from_top = coding.near_is_high;
    }
    push.top_code = from_top ? coding.code_max : 0;
    push.base = static_cast<float>(base);
    push.step = static_cast<float>(step);
    push.is_inverse = is_inverse;
}

template <class Values>
Result<GpuBuffer> uploaded(const GpuDevice& device, const char* name, const Values& values) {
    const std::size_t bytes = values.size() * sizeof(*values.data());
    // Whole texels, as lanes read them.
    auto buffer = GpuBuffer::create(device, name, std::max<std::size_t>(16, (bytes + 15) / 16 * 16),
                                    device.facts().unified_memory ? GpuMemory::shared : GpuMemory::upload);
    if (buffer.ok() && bytes > 0)
        std::memcpy(buffer->template mapped<std::byte>().data(), values.data(), bytes);
    return buffer;
}

}  // namespace

std::size_t SurfaceUnproject::q_bytes(int width, int height) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return 4 * UNPROJECT_PIXELS * ((pixels + UNPROJECT_PIXELS - 1) / UNPROJECT_PIXELS);
}

Result<GpuProgram> SurfaceUnproject::program_for(std::size_t bits) {
    GpuProgram& program = programs_[bits];
    if (program) return program;
    const auto bit = [bits](unsigned n) { return static_cast<std::uint32_t>(bits >> n & 1U); };
    const std::array<std::uint32_t, 4> constants{bit(0), bit(1), bit(2), bit(3)};
    const auto storage = GpuBindingKind::storage_buffer;
    auto made = GpuProgram::create(*device_, "unproject", unproject_spv,
                                   {sizeof(UnprojectPush),
                                    {storage, storage, storage, storage, storage, storage, storage},
                                    {UNPROJECT_LANES, 1, 1}},
                                   constants);
    if (made.ok()) program = *made;
    return made;
}

Result<GpuFramePlanes> SurfaceUnproject::upload(const SurfaceFrame& frame) const {
    auto codes = uploaded(*device_, "view codes", frame.codes);
    if (!codes.ok()) return codes.error();
    auto validity = uploaded(*device_, "view validity", frame.validity);
    if (!validity.ok()) return validity.error();
    auto heights = uploaded(*device_, "view heights", frame.heights);
    if (!heights.ok()) return heights.error();
    return GpuFramePlanes{*codes, *validity, *heights};
}

Result<void> SurfaceUnproject::record(GpuCommands& commands, const Scene& scene, const SurfaceFrame& prev,
                                      const SurfaceFrame& next, double blend,
                                      const GpuFramePlanes& prev_planes, const GpuFramePlanes& next_planes,
                                      const GpuBuffer& q) {
    UnprojectPush push{};
    push.width = static_cast<std::uint32_t>(prev.width);
    push.pixels = push.width * static_cast<std::uint32_t>(prev.height);
    push.validity_words = static_cast<std::uint32_t>(prev.validity_words_per_row());
    set_coding(prev.coding, push);
    push.cx = static_cast<float>(scene.camera.cx);
    push.cy = static_cast<float>(scene.camera.cy);
    push.per_fx = static_cast<float>(1.0 / scene.camera.fx);
    push.per_fy = static_cast<float>(1.0 / scene.camera.fy);
    const auto per_code =
        static_cast<float>(largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max);
    push.height_per_code = prev.heights.empty() ? 0.0F : per_code;
    push.next_height_per_code = next.heights.empty() ? 0.0F : per_code;
    push.blend = static_cast<float>(blend);
    push.rest = static_cast<float>(1.0 - blend);
    const bool has_heights = !prev.heights.empty() || !next.heights.empty();
    const std::size_t bits = (blend > 0 ? 1U : 0U) | (has_heights ? 2U : 0U) |
                             (prev.width % UNPROJECT_PIXELS != 0 ? 4U : 0U) |
                             (prev.coding.semantics == DepthSemantics::range ? 8U : 0U);
    const auto program = program_for(bits);
    if (!program.ok()) return program.error();
    commands.dispatch(*program, push,
                      {prev_planes.codes, prev_planes.validity, prev_planes.heights, next_planes.codes,
                       next_planes.validity, next_planes.heights, q},
                      groups_in_rows(groups_for(push.pixels, UNPROJECT_LANES * UNPROJECT_PIXELS)));
    return {};
}

Result<std::vector<float>> SurfaceUnproject::q_of(const HeightField& field, const FramePair& pair) {
    const double blend = field.blend();
    const SurfaceFrame& prev = *pair.prev.frame;
    const SurfaceFrame& next = blend > 0 ? *pair.next.frame : prev;
    if (prev.codes.empty() || next.codes.empty()) return touchable::q_of(field);
    auto prev_planes = upload(prev);
    if (!prev_planes.ok()) return prev_planes.error();
    auto next_planes = blend > 0 ? upload(next) : prev_planes;
    if (!next_planes.ok()) return next_planes.error();
    auto q = GpuBuffer::create(*device_, "view q", q_bytes(prev.width, prev.height), GpuMemory::readback);
    if (!q.ok()) return q.error();
    auto commands = GpuCommands::begin(device_, "unproject");
    if (!commands.ok()) return commands.error();
    if (auto recorded = record(*commands, field.scene(), prev, next, blend, *prev_planes, *next_planes, *q);
        !recorded.ok())
        return recorded.error();
    const auto submission = std::move(*commands).submit();
    if (!submission.ok()) return submission.error();
    if (auto done = submission->wait(); !done.ok()) return done.error();
    const auto made = q->mapped<float>();
    const std::size_t pixels = static_cast<std::size_t>(prev.width) * static_cast<std::size_t>(prev.height);
    return std::vector<float>(made.begin(), made.begin() + static_cast<std::ptrdiff_t>(pixels));
}

}  // namespace touchable
