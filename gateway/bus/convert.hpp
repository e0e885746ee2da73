/// @file  From the house's plain structs to the generated twins, field by field. A disagreement does not
/// compile.
#pragma once

#include <fastrtps/utils/fixed_size_string.hpp>

#include <array>
#include <type_traits>

#include "drivers/core/text.hpp"

namespace motionlab::bus {

namespace detail {

template <class Plain, class Twin>
inline constexpr bool kAgree = false;
template <class Scalar>
requires std::is_arithmetic_v<Scalar>
inline constexpr bool kAgree<Scalar, Scalar> = true;
template <class Plain, class Twin>
requires std::is_enum_v<Plain> && std::is_enum_v<Twin>
inline constexpr bool kAgree<Plain, Twin> =
    std::is_same_v<std::underlying_type_t<Plain>, std::underlying_type_t<Twin>>;
template <std::size_t N>
inline constexpr bool kAgree<Text<N>, eprosima::fastrtps::fixed_string<N>> = true;
template <class Plain, class Twin, std::size_t N>
inline constexpr bool kAgree<std::array<Plain, N>, std::array<Twin, N>> = kAgree<Plain, Twin>;

struct CopyToTwin {
  template <class Plain, class Twin>
  void operator()(const Plain& plain, Twin& twin) const noexcept {
    static_assert(
        kAgree<Plain, Twin>,
        "a field has one type in the plain struct and another in the generated twin: idl/plain.py and "
        "fastddsgen read the .idl file differently");
    copy(plain, twin);
  }

 private:
  template <class Plain, class Twin>
  static void copy(const Plain& plain, Twin& twin) noexcept {
    twin = static_cast<Twin>(plain);
  }
  template <std::size_t N>
  static void copy(const Text<N>& plain, eprosima::fastrtps::fixed_string<N>& twin) noexcept {
    std::array<char, N + 1> text{};  // a full Text has no room for the terminator that the twin asks for
    const std::string_view view = plain.view();
    view.copy(text.data(), view.size());
    twin = text.data();
  }
  template <class Plain, class Twin, std::size_t N>
  static void copy(const std::array<Plain, N>& plain, std::array<Twin, N>& twin) noexcept {
    for (std::size_t i = 0; i < N; ++i) copy(plain[i], twin[i]);
  }
};

}  // namespace detail

/// Copies every field. Allocates nothing.
template <class T, class Twin>
void to_twin(const T& plain, Twin& twin) noexcept {
  T::zip(plain, twin, detail::CopyToTwin{});
}

}  // namespace motionlab::bus
