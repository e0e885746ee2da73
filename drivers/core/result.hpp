/// @file  `Result<T>`: a value or a fault that says why and what to do. For everything that runs after
/// start-up; start-up itself throws (see error.hpp).
#pragma once

#include <cassert>
#include <cstdint>
#include <string_view>
#include <utility>
#include <variant>

namespace motionlab {

/// Why a piece of input was refused. Each reason is one counter on `motionlab/health`.
enum class Reason : std::uint8_t {
  too_short,     ///< fewer bytes than the layout needs
  too_long,      ///< more bytes than the layout has
  bad_header,    ///< wrong magic, type, length field, version or token
  bad_checksum,  ///< checksum policy is `enforce` and it did not match
  bad_value,     ///< not finite, or outside what the device can mean
  foreign,       ///< from an address that is not the device's
  duplicate,     ///< seen before
  out_of_order,  ///< older than what was accepted
  unexpected,    ///< well-formed, but not an answer to anything we asked
  refused,       ///< the device said no
  transport,     ///< the socket said no
  count_         ///< number of reasons
};

inline constexpr std::size_t kReasonCount = static_cast<std::size_t>(Reason::count_);

[[nodiscard]] constexpr std::string_view to_string(Reason reason) noexcept {
  constexpr std::string_view names[] = {"too_short",  "too_long", "bad_header", "bad_checksum",
                                        "bad_value",  "foreign",  "duplicate",  "out_of_order",
                                        "unexpected", "refused",  "transport"};
  return reason < Reason::count_ ? names[static_cast<std::size_t>(reason)] : std::string_view{"?"};
}

/// A reason and one constant sentence that says what was wrong and what to do. Copies nothing, allocates
/// nothing.
struct Fault {
  Reason reason{};
  std::string_view text{};  ///< points at a string literal
};

/// Either a T or a Fault. Reading the wrong one is a programming error (asserted).
template <class T>
class [[nodiscard]] Result {
 public:
  constexpr Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  constexpr Result(Fault fault) : state_(std::in_place_index<1>, fault) {}

  [[nodiscard]] constexpr bool ok() const noexcept { return state_.index() == 0; }
  constexpr explicit operator bool() const noexcept { return ok(); }
  [[nodiscard]] constexpr const T& value() const& noexcept {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] constexpr T&& value() && noexcept {
    assert(ok());
    return std::move(*std::get_if<0>(&state_));
  }
  constexpr const T& operator*() const& noexcept { return value(); }
  constexpr const T* operator->() const noexcept { return &value(); }
  [[nodiscard]] constexpr Fault fault() const noexcept {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }

 private:
  std::variant<T, Fault> state_;
};

/// Success without a value.
struct Done {};
using Status = Result<Done>;

}  // namespace motionlab
