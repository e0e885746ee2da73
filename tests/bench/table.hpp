/// @file  One row a comparison: ours, theirs, the ratio, the quantiles of single calls, what was allocated.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <vector>

#include "tests/support/malloc_calls.hpp"

namespace motionlab::test {

/// Measures and prints rows, and remembers whether all of ours allocated nothing and were the faster.
class Table {
 public:
  explicit Table(int pairs) : pairs_(pairs) {
    std::printf("%-34s %10s %10s %7s %17s %9s %9s %6s\n", "processor time of one call [us]", "ours", "theirs",
                "ratio", "(of all pairs)", "p50", "p99", "malloc");
  }

  /// `ours(i)` and `theirs(i)` do call i of a run; a run is `calls` of them, begun anew with i = 0.
  template <class Ours, class Theirs>
  void compare(const char* what, std::size_t calls, const Ours& ours, const Theirs& theirs) {
    seconds_of(calls, ours);
    seconds_of(calls, theirs);
    std::vector<double> ratio, our_s, their_s;
    for (int pair = 0; pair < pairs_; ++pair) {
      const bool first = pair % 2 == 0;  // neither always finds the other's warm cache
      if (first) our_s.push_back(seconds_of(calls, ours));
      their_s.push_back(seconds_of(calls, theirs));
      if (!first) our_s.push_back(seconds_of(calls, ours));
      ratio.push_back(their_s.back() / our_s.back());
    }
    std::sort(ratio.begin(), ratio.end());
    const double median_ratio = quantile(ratio, 0.5);
    all_faster_ = all_faster_ && median_ratio > 1;
    std::printf("%-34s %10.3f %10.3f %7.2f %17s", what, per_call_us(our_s, calls),
                per_call_us(their_s, calls), median_ratio, range(ratio).data());
    single_calls(calls, ours);
  }

  /// A row without a stranger.
  template <class Ours>
  void alone(const char* what, std::size_t calls, const Ours& ours) {
    seconds_of(calls, ours);
    std::vector<double> our_s;
    for (int i = 0; i < pairs_; ++i) our_s.push_back(seconds_of(calls, ours));
    std::printf("%-34s %10.3f %10s %7s %17s", what, per_call_us(our_s, calls), "", "", "");
    single_calls(calls, ours);
  }

  [[nodiscard]] bool nothing_allocated() const { return nothing_allocated_; }
  [[nodiscard]] bool all_faster() const { return all_faster_; }

 private:
  static double now_s(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
  template <class Work>
  static double seconds_of(std::size_t calls, const Work& work) {
    const double begin = now_s(CLOCK_PROCESS_CPUTIME_ID);
    for (std::size_t i = 0; i < calls; ++i) work(i);
    return now_s(CLOCK_PROCESS_CPUTIME_ID) - begin;
  }
  static double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }
  static double per_call_us(const std::vector<double>& run_s, std::size_t calls) {
    return 1e6 * quantile(run_s, 0.5) / static_cast<double>(calls);
  }
  static std::array<char, 32> range(const std::vector<double>& sorted) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "(%.2f to %.2f)", sorted.front(), sorted.back());
    return text;
  }
  /// Each call by itself, the clock's own some 30 ns included, and what it takes from the heap.
  template <class Work>
  void single_calls(std::size_t calls, const Work& work) {
    constexpr std::size_t kFewest = 2000;
    std::vector<double> us((1 + kFewest / calls) * calls);
    std::size_t mallocs = 0;
    for (std::size_t i = 0; i < us.size(); ++i) {
      const std::size_t before = malloc_calls;
      const double begin = now_s(CLOCK_MONOTONIC);
      work(i % calls);
      us[i] = 1e6 * (now_s(CLOCK_MONOTONIC) - begin);
      mallocs += malloc_calls - before;
    }
    nothing_allocated_ = nothing_allocated_ && mallocs == 0;
    std::printf(" %9.3f %9.3f %6zu\n", quantile(us, 0.50), quantile(us, 0.99), mallocs);
  }

  int pairs_;
  bool nothing_allocated_ = true;
  bool all_faster_ = true;
};

}  // namespace motionlab::test
