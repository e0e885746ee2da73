/// @file  Where a driver tells its samples to. The assembly decides who listens.
#pragma once

#include <functional>

namespace motionlab {

template <class T>
using Sink = std::function<void(const T&)>;

}  // namespace motionlab
