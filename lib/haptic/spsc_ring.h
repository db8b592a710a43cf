#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace tissue {

/// A queue between one thread that pushes and one that pops. There is no lock, no allocation after construction, and
/// neither thread waits. capacity is rounded up to a power of two.
template <class Item>
class SpscRing {
   public:
    explicit SpscRing(std::size_t capacity) {
        std::size_t size = 2;
        while (size < capacity) size *= 2;
        items_.resize(size);
    }

    /// False where the queue is full; the item is dropped.
    bool push(const Item& item) noexcept {
        const std::size_t head = head_.load(std::memory_order_relaxed);
        if (head - tail_.load(std::memory_order_acquire) == items_.size()) return false;
        items_[head & (items_.size() - 1)] = item;
        head_.store(head + 1, std::memory_order_release);
        return true;
    }

    bool pop(Item& item) noexcept {
        const std::size_t tail = tail_.load(std::memory_order_relaxed);
        if (tail == head_.load(std::memory_order_acquire)) return false;
        item = items_[tail & (items_.size() - 1)];
        tail_.store(tail + 1, std::memory_order_release);
        return true;
    }

    std::size_t capacity() const { return items_.size(); }

   private:
    std::vector<Item> items_;
    alignas(64) std::atomic<std::size_t> head_{0};  ///< written by the thread that pushes
    alignas(64) std::atomic<std::size_t> tail_{0};  ///< written by the thread that pops
};

}  // namespace tissue
