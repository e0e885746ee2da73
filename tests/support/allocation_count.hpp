/// @file  What this thread has taken from the heap, in a program of which one source includes
/// allocations.hpp.
#pragma once

#include <cstddef>

namespace motionlab::test {

inline thread_local std::size_t allocations = 0;

}  // namespace motionlab::test
