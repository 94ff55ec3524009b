#include "player/window/window_film.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/start_thread.hpp"

namespace touchable {

Result<std::unique_ptr<WindowFilm>> WindowFilm::create(std::shared_ptr<GpuDevice> device,
                                                       const std::filesystem::path& file, Existing existing) {
    auto film = FilmWriter::create(file, existing);
    if (!film.ok()) return film.error();
    std::unique_ptr<WindowFilm> made(new WindowFilm(std::move(device), std::move(*film)));
    auto begun = start_thread(made->thread_, "of the film", [it = made.get()] { it->encode(); });
    if (!begun.ok()) return begun.error();
    return made;
}

WindowFilm::~WindowFilm() {
    stop();
}

void WindowFilm::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

std::optional<Error> WindowFilm::failure() const {
    const std::lock_guard lock(mutex_);
    return encoded_.ok() ? std::nullopt : std::optional(encoded_.error());
}

/// Nothing where all of them wait.
Result<std::optional<GpuBuffer>> WindowFilm::free_buffer(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (in_use_ == most_waiting) return std::optional<GpuBuffer>();
    std::erase_if(free_, [bytes](const GpuBuffer& buffer) { return buffer.bytes() != bytes; });
    if (free_.empty()) {
        auto made = GpuBuffer::create(*device_, "picture of a film", bytes, GpuMemory::readback);
        if (!made.ok()) return made.error();
        free_.push_back(std::move(*made));
    }
    std::optional<GpuBuffer> taken(std::move(free_.back()));
    free_.pop_back();
    ++in_use_;
    return taken;
}

Result<void> WindowFilm::record(GpuCommands& commands, const GpuImage& canvas, double seconds) {
    const auto place = static_cast<std::int64_t>(std::floor(seconds * FilmWriter::pictures_per_second));
    if (place <= last_place_ || failure()) return {};
    const VkExtent2D extent = canvas.extent();
    auto buffer = free_buffer(std::size_t{4} * extent.width * extent.height);
    if (!buffer.ok()) return buffer.error();
    last_place_ = place;
    if (!*buffer) {
        ++left_out_;
        return {};
    }
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands.handle(), canvas.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           (*buffer)->handle(), 1, &region);
    commands.keep((*buffer)->keep_alive());
    recorded_.emplace(
        Picture{std::move(**buffer), static_cast<int>(extent.width), static_cast<int>(extent.height), place});
    return {};
}

void WindowFilm::drawn() {
    if (!recorded_) return;
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(*recorded_));
    }
    recorded_.reset();
    changed_.notify_all();
}

/// Until it is to stop and nothing waits, or the film cannot be written.
void WindowFilm::encode() {
    std::unique_lock lock(mutex_);
    while (encoded_.ok()) {
        changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        Picture next = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        auto added =
            film_->add({next.pixels.mapped<std::uint8_t>().data(), next.width, next.height}, next.place);
        lock.lock();
        encoded_ = std::move(added);
        free_.push_back(std::move(next.pixels));
        --in_use_;
    }
}

Result<void> WindowFilm::finish(double seconds) {
    stop();
    if (const auto failed = failure()) return *failed;
    const auto end = static_cast<std::int64_t>(std::ceil(seconds * FilmWriter::pictures_per_second));
    pictures_ = std::max(end, last_place_ + 1);
    return film_->finish(pictures_);
}

}  // namespace touchable
