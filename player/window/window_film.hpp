#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "engine/gpu/gpu_buffer.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/media/film_writer.hpp"
#include "engine/result.hpp"
#include "player/view/gpu_image.hpp"

namespace touchable {

/// What the window shows, as a film. Pictures are encoded on a thread of their own; one for which there is no
/// room there is left out, so that the window never waits.
class WindowFilm {
public:
    static Result<std::unique_ptr<WindowFilm>> create(std::shared_ptr<GpuDevice> device,
                                                      const std::filesystem::path& file, Existing existing);
    ~WindowFilm();
    WindowFilm(const WindowFilm&) = delete;
    WindowFilm& operator=(const WindowFilm&) = delete;

    // The window's.
    /// Records what copies `canvas`, which is in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, where the film has a
    /// place for a picture of this moment; times do not go backward.
    Result<void> record(GpuCommands& commands, const GpuImage& canvas, double seconds);
    /// The commands have completed.
    void drawn();
    /// Pictures that found no room.
    std::int64_t left_out() const { return left_out_; }
    /// In the film, once it is finished.
    std::int64_t pictures() const { return pictures_; }
    /// Why there will be no film, where it is known already.
    std::optional<Error> failure() const;
    /// Completes the file, so long after the first picture. An error where it could not be written; then
    /// there is none.
    Result<void> finish(double seconds);

private:
    struct Picture {
        GpuBuffer pixels;
        int width, height;
        std::int64_t place;
    };
    WindowFilm(std::shared_ptr<GpuDevice> device, std::unique_ptr<FilmWriter> film)
        : device_(std::move(device)), film_(std::move(film)) {}
    Result<std::optional<GpuBuffer>> free_buffer(std::size_t bytes);
    void encode();
    void stop();

    static constexpr std::size_t most_waiting = 4;  // pictures, with the one that is being encoded
    std::shared_ptr<GpuDevice> device_;
    std::unique_ptr<FilmWriter> film_;
    std::optional<Picture> recorded_;
    std::int64_t last_place_ = -1, left_out_ = 0, pictures_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<Picture> waiting_;
    std::vector<GpuBuffer> free_;
    std::size_t in_use_ = 0;  // buffers that are not free
    bool stopping_ = false;
    Result<void> encoded_;
    std::thread thread_;
};

}  // namespace touchable
