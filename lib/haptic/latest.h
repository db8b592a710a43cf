#pragma once

#include <atomic>

namespace tissue {

/// The newest value of one thread, for one other: three copies that change hands by one atomic exchange, so that
/// neither side locks, waits, or sees half a value. Values that nobody fetched in time are overwritten. Nothing is
/// allocated but what assigning an Item allocates.
template <class Item>
class Latest {
   public:
    explicit Latest(const Item& initial = {}) : items_{initial, initial, initial} {}

    /// The writer's: to be filled, then published. What it held before is some older value.
    Item& back() noexcept { return items_[back_]; }
    void publish() noexcept { back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & ~fresh; }

    /// The reader's: true when a newer value has become front().
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
    alignas(64) unsigned back_ = 0;                  ///< the writer's alone
    alignas(64) std::atomic<unsigned> middle_{1};    ///< with `fresh` while nobody has fetched it
    alignas(64) unsigned front_ = 2;                 ///< the reader's alone
};

}  // namespace tissue
