/// @file  The components of a data packet: their numbers, and the words by which clients ask for them.
/// Source: QTM RT Protocol documentation, "Data packet", "StreamFrames".
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

namespace motionlab::qualisys {

/// Component numbers on the wire. Those of which this codec knows no layout are passed over by their size.
enum class Component : std::uint32_t {
  markers = 1,     ///< `3D`: labelled markers, always all, in the order of the labels
  unlabelled = 2,  ///< `3DNoLabels`: the others, as many as are seen
  analog = 3,
  force = 4,
  bodies = 5,  ///< `6D`: position and matrix
  angles = 6,  ///< `6DEuler`: position and three angles
  two_d = 7,
  two_d_linear = 8,
  markers_res = 9,  ///< `3DRes`, with residual; likewise below
  unlabelled_res = 10,
  bodies_res = 11,
  angles_res = 12,
  analog_single = 13,
  image = 14,
  force_single = 15,
  gaze_vector = 16,
  timecode = 17,  ///< `Timecode`
  skeleton = 18,
  eye_tracker = 19,
};

/// The word for a component in a command, e.g. `6DRes`.
struct ComponentWord {
  std::string_view word;
  Component component;
};
inline constexpr auto kComponentWords = std::to_array<ComponentWord>({
    {"3D", Component::markers},
    {"3DRes", Component::markers_res},
    {"3DNoLabels", Component::unlabelled},
    {"3DNoLabelsRes", Component::unlabelled_res},
    {"6D", Component::bodies},
    {"6DRes", Component::bodies_res},
    {"6DEuler", Component::angles},
    {"6DEulerRes", Component::angles_res},
    {"Timecode", Component::timecode},
    {"2D", Component::two_d},
    {"2DLin", Component::two_d_linear},
    {"Analog", Component::analog},
    {"AnalogSingle", Component::analog_single},
    {"Force", Component::force},
    {"ForceSingle", Component::force_single},
    {"Image", Component::image},
    {"GazeVector", Component::gaze_vector},
    {"Skeleton", Component::skeleton},
    {"EyeTracker", Component::eye_tracker},
});

/// A set of components.
class Components {
 public:
  constexpr Components() noexcept = default;
  constexpr Components(std::initializer_list<Component> components) noexcept {
    for (const Component component : components) add(component);
  }
  constexpr void add(Component component) noexcept { bits_ |= bit(component); }
  [[nodiscard]] constexpr bool has(Component component) const noexcept {
    return (bits_ & bit(component)) != 0;
  }
  constexpr void add(const Components& others) noexcept { bits_ |= others.bits_; }
  [[nodiscard]] constexpr bool overlaps(const Components& others) const noexcept {
    return (bits_ & others.bits_) != 0;
  }
  [[nodiscard]] constexpr bool empty() const noexcept { return bits_ == 0; }
  bool operator==(const Components&) const = default;

 private:
  static constexpr std::uint32_t bit(Component component) noexcept {
    return 1u << static_cast<std::uint32_t>(component);
  }
  std::uint32_t bits_ = 0;
};

/// The component of a word, in any case of letters and without what follows a colon (`Analog:1,2`).
[[nodiscard]] std::optional<Component> component_of(std::string_view word) noexcept;
[[nodiscard]] std::string_view word_of(Component component) noexcept;

}  // namespace motionlab::qualisys
