#include "gateway/deadman/page/lifeline.hpp"

#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <utility>

namespace motionlab::deadman {
namespace {

/// How long the deadman may take to go once it is not needed any more.
constexpr int kGoodbyeMilliseconds = 500;

}  // namespace

File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

File::File(File&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Lifeline::Lifeline(Page& page, File pipe, File deadman) noexcept
    : page_(page), pipe_(std::move(pipe)), deadman_(std::move(deadman)) {}

Lifeline::~Lifeline() {
  if (page_.sent.version() == 0) end_in_order();
  if (page_.phase.load(std::memory_order_relaxed) != Phase::ended) return;
  pollfd gone{deadman_.fd(), POLLIN, 0};
  (void)::poll(&gone, 1, kGoodbyeMilliseconds);
}

void Lifeline::sent(bool follow, const std::array<double, comau::kJointCount>& qd_radps) noexcept {
  LastSent last;
  last.t_monotonic_ns = std::chrono::steady_clock::now().time_since_epoch().count();
  last.command.mode = static_cast<std::int32_t>(follow ? comau::Mode::follow : comau::Mode::hold);
  for (std::size_t i = 0; i < comau::kJointCount; ++i)
    last.command.qd_radps[i] = static_cast<float>(qd_radps[i]);
  page_.sent.write(last);
}

void Lifeline::io_beat() noexcept {
  page_.io_beats.fetch_add(1, std::memory_order_relaxed);
  const std::uint64_t ticks = page_.deadman_ticks.load(std::memory_order_relaxed);
  beats_since_look_ = ticks == ticks_seen_ ? beats_since_look_ + 1 : 0;
  ticks_seen_ = ticks;
}

void Lifeline::control_beat() noexcept {
  page_.control_beats.fetch_add(1, std::memory_order_relaxed);
}

void Lifeline::leave() noexcept {
  page_.phase.store(Phase::leaving, std::memory_order_release);
}

void Lifeline::end_in_order() noexcept {
  page_.phase.store(Phase::ended, std::memory_order_release);
}

}  // namespace motionlab::deadman
