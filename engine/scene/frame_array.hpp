#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace touchable {

/// One plane of a frame: an array in memory of its own, or in somebody else's that it keeps alive (a GPU's,
/// mapped). Whatever changes its size makes it own its memory again; a copy always does.
template <class T>
class FrameArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    using value_type = T;
    using iterator = T*;
    using const_iterator = const T*;

    FrameArray() = default;
    FrameArray(const FrameArray& other) : own_(other.begin(), other.end()) { show_own(); }
    FrameArray(FrameArray&& other) noexcept { swap(other); }
    FrameArray& operator=(FrameArray other) noexcept {
        swap(other);
        return *this;
    }
    ~FrameArray() = default;

    /// `memory` belongs to `owner` and is the array from now on.
    void adopt(std::span<T> memory, std::shared_ptr<const void> owner) {
        own_ = {};
        owner_ = std::move(owner);
        data_ = memory.data();
        size_ = memory.size();
    }
    bool adopted() const { return owner_ != nullptr; }

    /// New elements are zero; adopted ones are forgotten, as they are by `assign` and `clear`.
    void resize(std::size_t size) {
        change([&] { own_.resize(size); });
    }
    void assign(std::size_t size, const T& value) {
        change([&] { own_.assign(size, value); });
    }
    void clear() {
        change([&] { own_.clear(); });
    }
    void push_back(const T& value) {
        change([&] { own_.push_back(value); });
    }

    T* data() { return data_; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T& operator[](std::size_t n) { return data_[n]; }
    const T& operator[](std::size_t n) const { return data_[n]; }
    iterator begin() { return data_; }
    iterator end() { return data_ + size_; }
    const_iterator begin() const { return data_; }
    const_iterator end() const { return data_ + size_; }

    friend bool operator==(const FrameArray& a, const FrameArray& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }
    friend bool operator==(const FrameArray& a, const std::vector<T>& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

private:
    template <class Change>
    void change(Change&& change_own) {
        owner_.reset();
        change_own();
        show_own();
    }
    void show_own() {
        data_ = own_.data();
        size_ = own_.size();
    }
    void swap(FrameArray& other) noexcept {
        own_.swap(other.own_);
        owner_.swap(other.owner_);
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
    }

    std::vector<T> own_;
    std::shared_ptr<const void> owner_;  // of adopted memory
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace touchable
