#pragma once

#include <atomic>

namespace tissue {

/// Passes the newest value from one writer thread to one reader thread (triple buffer). Three copies change places by
/// one atomic exchange, so neither side locks, waits or sees half a value. A value that is not fetched in time is
/// overwritten. Nothing is allocated, except by the assignment of an Item.
template <class Item>
class Latest {
   public:
    explicit Latest(const Item& initial = {}) : items_{initial, initial, initial} {}

    /// For the writer: fill back(), then publish(). Before that back() has some older value.
    Item& back() noexcept { return items_[back_]; }
    void publish() noexcept { back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & ~fresh; }

    /// For the reader: true when a newer value has become front().
    bool fetch() noexcept {
        if (!(middle_.load(std::memory_order_relaxed) & fresh)) return false;
        front_ = middle_.exchange(front_, std::memory_order_acq_rel) & ~fresh;
        return true;
    }
    const Item& front() const noexcept { return items_[front_]; }

   private:
    static constexpr unsigned fresh = 4;
    static_assert(std::atomic<unsigned>::is_always_lock_free, "used in the tick");

    Item items_[3];
    alignas(64) unsigned back_ = 0;                  ///< used by the writer only
    alignas(64) std::atomic<unsigned> middle_{1};    ///< with the bit `fresh` until it is fetched
    alignas(64) unsigned front_ = 2;                 ///< used by the reader only
};

}  // namespace tissue
