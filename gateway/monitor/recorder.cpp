#include "gateway/monitor/recorder.hpp"

#include <pthread.h>

#include <utility>

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kPause = 20ms;  // of the writing thread, when there is nothing to write

record::RecordingOptions on_occasion(record::RecordingOptions options, bool is) {
  options.on_occasion = is;
  return options;
}

}  // namespace

Recorder::Recorder(const bus::DdsConfig& dds, const bus::TapOptions& tap, record::RecordingOptions options,
                   const std::optional<EventWindow>& window)
    : tap_(dds, tap), recording_(on_occasion(std::move(options), window.has_value()), clock_.now()) {
  if (window) windows_.emplace(*window, clock_.now(), recording_);
  thread_ = std::thread([this] { write(); });
}

Recorder::~Recorder() {
  (void)finish();
}

std::size_t Recorder::listen() {
  const std::size_t heard = tap_.take([this](const bus::TappedSample& sample) { (void)queue_.push(sample); });
  for (std::size_t topic = 0; topic < bus::kTopicList.size(); ++topic)
    queue_.ledger().refused(topic, tap_.refused(topic));
  return heard;
}

void Recorder::write() {
  pthread_setname_np(pthread_self(), "recorder");
  const auto take = [this](const record::SampleToRecord& sample, Bytes cdr) {
    windows_ ? windows_->take(sample, cdr) : recording_.take(sample, cdr);
  };
  LabTime next_look{};
  for (;;) {
    const bool last = stopping_.load(std::memory_order_acquire);  // before the queue is seen empty
    const bool any = queue_.pop(take);
    const LabTime now = clock_.now();
    if (!any || now >= next_look) {
      next_look = now + kPause;
      if (windows_) {
        windows_->keep_up(now);
        opened_.store(windows_->count(), std::memory_order_relaxed);
      }
      recording_.keep_up(now);
      messages_.store(recording_.messages(), std::memory_order_relaxed);
      bytes_.store(recording_.bytes(), std::memory_order_relaxed);
      rounds_.fetch_add(1, std::memory_order_relaxed);
      if (auto trouble = recording_.trouble()) {
        const std::lock_guard lock(mutex_);
        trouble_ = std::move(trouble);
        return;
      }
    }
    if (any) continue;
    if (last) return;
    std::this_thread::sleep_for(kPause);
  }
}

const record::Recording& Recorder::finish() {
  if (thread_.joinable()) {
    stopping_.store(true, std::memory_order_release);
    thread_.join();
    recording_.finish(queue_.ledger().all());
  }
  return recording_;
}

std::optional<std::string> Recorder::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

}  // namespace motionlab::monitor
