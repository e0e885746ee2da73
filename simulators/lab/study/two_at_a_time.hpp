/// @file  Many independent runs on two processors.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>

namespace motionlab::study {

/// Calls `work(i)` once for every i below `count`, on two threads, in about this order. What a call throws is
/// thrown here when both have ended; what has not begun by then is left out.
template <class Work>
void two_at_a_time(std::size_t count, const Work& work) {
  constexpr std::size_t kAtATime = 2;
  std::atomic<std::size_t> next{0};
  std::array<std::exception_ptr, kAtATime> problems;
  const auto take = [&](std::exception_ptr& problem) {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    } catch (...) {
      problem = std::current_exception();
      next = count;
    }
  };
  {
    std::array<std::jthread, kAtATime> workers;
    for (std::size_t w = 0; w < kAtATime; ++w) workers[w] = std::jthread([&, w] { take(problems[w]); });
  }
  for (const auto& problem : problems) {
    if (problem) std::rethrow_exception(problem);
  }
}

}  // namespace motionlab::study
