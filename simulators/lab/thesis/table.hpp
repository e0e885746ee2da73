/// @file  Every printed number of the thesis beside ours.
#pragma once

#include <string>

namespace motionlab::thesis {

/// The tables and gains of the thesis as printed, ours, the largest difference of an entry, and *confirmed*
/// or *corrected: why*. Chapter 5 prints curves only; what these scenarios give here stands at the end. The
/// text is the same on every call; it takes some seconds, for all scenarios are run.
[[nodiscard]] std::string comparison_table();

}  // namespace motionlab::thesis
