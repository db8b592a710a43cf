#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

namespace tissue {

/// Counts, writes or reads the bytes of everything that changes while a session runs. A class with such state has
///     void fields(StateBytes& state) { state(a, b, c); }
/// Sizes of vectors and matrices do not change after construction of a session. So the number of bytes is constant, and
/// nothing allocates.
class StateBytes {
   public:
    static StateBytes counting() { return {nullptr, nullptr}; }
    static StateBytes writing(std::byte* to) { return {to, nullptr}; }
    static StateBytes reading(const std::byte* from) { return {nullptr, from}; }

    template <class... Fields>
    void operator()(Fields&... each) noexcept {
        (field(each), ...);
    }

    std::size_t size() const { return size_; }  ///< number of bytes so far
    bool reads() const { return from_ != nullptr; }

   private:
    StateBytes(std::byte* to, const std::byte* from) : to_(to), from_(from) {}

    template <class T, class = void>
    struct HasFields : std::false_type {};
    template <class T>
    struct HasFields<T, std::void_t<decltype(std::declval<T&>().fields(std::declval<StateBytes&>()))>> : std::true_type {};

    void raw(void* data, std::size_t bytes) noexcept {
        if (to_ && bytes > 0) std::memcpy(to_ + size_, data, bytes);
        if (from_ && bytes > 0) std::memcpy(data, from_ + size_, bytes);
        size_ += bytes;
    }

    template <class T>
    void field(T& value) noexcept {
        if constexpr (HasFields<T>::value) {
            value.fields(*this);
        } else {
            static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "give it fields()");
            raw(&value, sizeof value);
        }
    }

    /// A matrix of fixed size, of bounded size (stored as its bound), or of the size that the session gave it.
    template <class T, int R, int C, int O, int MR, int MC>
    void field(Eigen::Matrix<T, R, C, O, MR, MC>& value) noexcept {
        constexpr bool small = MR != Eigen::Dynamic && MC != Eigen::Dynamic;
        if constexpr (small && (R == Eigen::Dynamic || C == Eigen::Dynamic)) {
            Eigen::Index rows = value.rows(), cols = value.cols();
            (*this)(rows, cols);
            Eigen::Matrix<T, MR, MC, Eigen::ColMajor> all = Eigen::Matrix<T, MR, MC, Eigen::ColMajor>::Zero();
            all.topLeftCorner(value.rows(), value.cols()) = value;
            raw(all.data(), sizeof(T) * static_cast<std::size_t>(all.size()));
            if (from_) value = all.topLeftCorner(rows, cols);
        } else {
            raw(value.data(), sizeof(T) * static_cast<std::size_t>(value.size()));
        }
    }

    template <class T>
    void field(std::vector<T>& values) noexcept {
        if constexpr (std::is_arithmetic_v<T>)
            raw(values.data(), sizeof(T) * values.size());
        else
            for (T& value : values) field(value);
    }

    template <class T, std::size_t n>
    void field(T (&values)[n]) noexcept {
        for (T& value : values) field(value);
    }

    std::byte* to_;
    const std::byte* from_;
    std::size_t size_ = 0;
};

}  // namespace tissue
