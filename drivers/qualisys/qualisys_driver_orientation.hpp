/// @file  Whether orientations are written as we read them: the matrix against the angles of the same body.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"

namespace motionlab::qualisys {

/// Compares both forms of orientation of one frame. The documentation of the matrix does not say whether it
/// is written by rows or by columns, and a wrong guess turns every rotation about; but angles tell.
///
/// A body whose matrix is nearly symmetric (upright, or turned by half) decides nothing about the order: the
/// check asks again, once a second, until a body lies askew.
class OrientationCheck {
 public:
  enum class Verdict : std::uint8_t {
    undecided,   ///< not checked yet, or no body lies askew
    agree,       ///< matrix and angles of a body are the same rotation
    transposed,  ///< the angles are those of the inverse rotation: the matrix is written by rows
    disagree,    ///< neither: the project defines its angles otherwise
  };

  /// Whether a frame with both forms should be asked for now.
  [[nodiscard]] bool due(LabTime now) const noexcept {
    return verdict_ == Verdict::undecided && (!t_asked_ || now - *t_asked_ >= 1s);
  }
  void asked(LabTime now) noexcept { t_asked_ = now; }
  /// Looks at a frame with both forms. @returns whether that changed the verdict
  bool judge(const DataFrame& frame) noexcept;
  void reset() noexcept { *this = {}; }

  [[nodiscard]] Verdict verdict() const noexcept { return verdict_; }
  /// What to tell people; empty while nothing is known to be wrong.
  [[nodiscard]] std::string_view advice() const noexcept;

 private:
  Verdict verdict_ = Verdict::undecided;
  std::optional<LabTime> t_asked_;
};

}  // namespace motionlab::qualisys
