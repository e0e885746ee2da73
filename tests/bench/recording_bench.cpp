// How many messages a second a recording takes, from the queue to a RAM disk, with two threads as in
// `motionlab record`: one pushes what it heard, one compresses and writes.
//   bench_recording [--short] [FOLDER]     the folder: /dev/shm
// Nothing may be lost and the file must be whole. Without --short it ends with 1 below the goal, by the clock
// on the wall: run it on a machine that does nothing else.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include "gateway/record/inspection.hpp"
#include "gateway/record/recording.hpp"
#include "gateway/record/sample_queue.hpp"

namespace {

using namespace motionlab;

constexpr std::size_t kPayload = 256;
constexpr double kGoal = 200'000;            // messages a second
constexpr std::uint64_t kOnTheWay = 20'000;  // fits into the queue

double processor_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Half of it noise, as measurements are, half of it at rest.
class Payload {
 public:
  Payload() : bytes_(kPayload) { bytes_[1] = std::byte{1}; }
  std::span<const std::byte> next() {
    for (std::size_t i = 4; i < kPayload / 2; ++i) {
      state_ ^= state_ << 13;
      state_ ^= state_ >> 7;
      state_ ^= state_ << 17;
      bytes_[i] = static_cast<std::byte>(state_);
    }
    return bytes_;
  }

 private:
  std::vector<std::byte> bytes_;
  std::uint64_t state_ = 88172645463325252;
};

struct Figures {
  double wall_s = 0, push_s = 0, write_s = 0;
  std::uint64_t lost = 0;
};

Figures run(record::Recording& recording, std::uint64_t count) {
  record::SampleQueue queue;
  std::atomic<std::uint64_t> taken{0};
  Figures figures;
  const auto start = std::chrono::steady_clock::now();
  std::thread writer([&] {
    const double begin = processor_s();
    while (taken.load(std::memory_order_relaxed) < count) {
      const bool any = queue.pop([&](const record::SampleToRecord& sample, Bytes cdr) {
        recording.take(sample, cdr);
        if (sample.sequence % 256 == 0) recording.keep_up(from_ns(sample.t_heard_ns));
      });
      if (any) {
        taken.fetch_add(1, std::memory_order_release);
      } else {
        std::this_thread::sleep_for(100us);
      }
    }
    recording.finish(queue.ledger().all());
    figures.write_s = processor_s() - begin;
  });
  const double begin = processor_s();
  Payload payload;
  for (std::uint64_t i = 1; i <= count; ++i) {
    while (i > taken.load(std::memory_order_acquire) + kOnTheWay) std::this_thread::sleep_for(100us);
    const auto t_ns = static_cast<std::int64_t>(i * 5'000);  // 200 000 a second
    const bool pushed = queue.push({.topic = bus::topic_index<topic::Mru>(),
                                    .instance = {},
                                    .cdr = payload.next(),
                                    .writer = {},
                                    .writer_sequence = i,
                                    .t_written_ns = t_ns,
                                    .t_heard_ns = t_ns});
    if (!pushed) ++figures.lost;
  }
  figures.push_s = processor_s() - begin;
  writer.join();
  figures.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  bool brief = false;
  std::filesystem::path folder = "/dev/shm";
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--short") {
      brief = true;
    } else {
      folder = argv[i];
    }
  }
  const std::uint64_t count = brief ? 100'000 : 4'000'000;
  const auto file = folder / ("motionlab-bench-" + std::to_string(getpid()) + ".mcap");
  record::Recording recording({.file = file}, from_ns(0));
  const Figures figures = run(recording, count);
  std::uint64_t read = 0, bytes = 0;
  bool whole = true;
  for (const auto& part : recording.files()) {
    std::ifstream in(part, std::ios::binary);
    const record::Inspection seen = record::inspect(in);
    read += seen.messages();
    whole = whole && seen.whole();
    bytes += std::filesystem::file_size(part);
    std::filesystem::remove(part);
  }
  const auto n = static_cast<double>(count);
  const double sustained = n / figures.wall_s;
  std::printf("%.0f messages of %zu bytes in %.2f s, %.1f MB: %.0f a second\n", n, kPayload, figures.wall_s,
              1e-6 * static_cast<double>(bytes), sustained);
  std::printf("processor time of one: %.2f us to push, %.2f us to write; %llu lost, %s\n",
              1e6 * figures.push_s / n, 1e6 * figures.write_s / n,
              static_cast<unsigned long long>(figures.lost), whole && read == count ? "whole" : "NOT WHOLE");
  if (!whole || read != count || figures.lost > 0) return 1;
  return brief || sustained >= kGoal ? 0 : 1;
}
