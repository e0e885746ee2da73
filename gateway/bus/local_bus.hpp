/// @file  `LocalBus`: samples from thread to thread within one process. No DDS, no lock, no allocation on the
/// way.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "drivers/core/latest.hpp"
#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"
#include "gateway/bus/bounded_queue.hpp"
#include "gateway/bus/topics.hpp"
#include "gateway/bus/wakeup.hpp"

namespace motionlab::bus {

class LocalBus;

namespace detail {

template <class T>
consteval std::size_t key_count() {
  if constexpr (T::kKeyed) {
    return std::tuple_size_v<decltype(std::declval<const T&>().key())>;
  } else {
    return 0;
  }
}

/// The values of the key fields, in order: which device, which body.
template <class T>
using InstanceName = std::array<Text<32>, key_count<T>()>;

template <class T>
InstanceName<T> instance_name(const T& sample) noexcept {
  InstanceName<T> name;
  if constexpr (T::kKeyed) {
    const auto key = sample.key();
    for (std::size_t i = 0; i < key.size(); ++i) name[i].assign(key[i]);
  }
  return name;
}

using PublisherId = std::uint32_t;
inline constexpr PublisherId kNobody = 0;

/// A name that one thread may change while others compare. It is read whole or not at all.
template <class T>
class SharedName {
 public:
  void set(const InstanceName<T>& name) noexcept {
    const Words words = words_of(name);
    turn_.fetch_add(1, std::memory_order_acq_rel);  // odd: being changed
    for (std::size_t i = 0; i < words.size(); ++i) words_[i].store(words[i], std::memory_order_release);
    turn_.fetch_add(1, std::memory_order_release);
  }
  [[nodiscard]] bool operator==(const InstanceName<T>& name) const noexcept {
    const Words words = words_of(name);
    const std::uint32_t turn = turn_.load(std::memory_order_acquire);
    if (turn % 2 != 0) return false;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words_[i].load(std::memory_order_acquire) != words[i]) return false;
    }
    return turn_.load(std::memory_order_relaxed) == turn;
  }

 private:
  using Words = std::array<std::uint64_t, sizeof(Text<32>) / sizeof(std::uint64_t) * key_count<T>()>;
  static Words words_of(const InstanceName<T>& name) noexcept {
    Words words{};
    if constexpr (key_count<T>() > 0) std::memcpy(words.data(), name.data(), sizeof words);
    return words;
  }

  std::atomic<std::uint32_t> turn_{0};
  std::array<std::atomic<std::uint64_t>, std::tuple_size_v<Words>> words_{};
};

/// Who publishes. Strangers (whoever speaks by DDS) come under many names: when the table is full a new one
/// takes the place of the one of theirs that was silent for longest.
struct PublisherIdentity {
  PublisherId id = kNobody;
  bool of_strangers = false;
};

/// One topic within the process: its instances and who subscribed.
template <class T>
class Topic {
 public:
  static constexpr std::size_t kMaxInstances = kEverySampleCounts<T> ? 0 : (T::kKeyed ? 16 : 1);
  static constexpr std::size_t kMaxSubscriptions = 8;
  static constexpr std::size_t kQueueDepth = 256;
  /// Of these, what is kept for samples that must arrive. When they too are spent, such a sample is the last
  /// one in the queue, and another would say nothing new.
  static constexpr std::size_t kKept = std::is_same_v<T, topic::ModeRequest> ? 16 : 0;

  struct Instance {
    SharedName<T> name;
    std::atomic<PublisherId> owner{kNobody};
    Latest<T> latest;
    bool kept = false;  ///< a Reader looks at it for ever; under the lock
    mutable std::atomic<bool> looked_up{
        false};                 ///< by name, since strangers' places were last looked through
    bool in_use = false;        ///< was looked up before that; its owner's
    std::uint64_t written = 0;  ///< which of the samples of strangers was the last; its owner's
  };

  struct Inbox {
    BoundedQueue<T> queue{kQueueDepth};
    std::atomic<std::uint64_t> lost{0};
    std::atomic<bool> open{true};
    PublisherId except = kNobody;
    std::shared_ptr<Wakeup> wakeup;
  };

  bool publish(const T& sample, PublisherIdentity publisher) noexcept {
    if constexpr (!kEverySampleCounts<T>) {
      const InstanceName<T> name = instance_name(sample);
      Instance* instance = find_or_add(name);
      if (!instance && publisher.of_strangers) instance = replace_for(name, publisher.id);
      if (!instance || !claim(*instance, publisher.id)) {
        refused_.fetch_add(1, std::memory_order_relaxed);
        return false;
      }
      if (publisher.of_strangers) instance->written = ++strangers_samples_;
      instance->latest.write(sample);
    }
    const std::size_t count = inbox_count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i) {
      Inbox& inbox = *inboxes_[i];
      if (!inbox.open.load(std::memory_order_relaxed) || inbox.except == publisher.id) continue;
      if (!inbox.queue.push(sample, must_arrive(sample) ? 0 : kKept))
        inbox.lost.fetch_add(1, std::memory_order_relaxed);
      if (inbox.wakeup) inbox.wakeup->ring();
    }
    return true;
  }

  /// Takes a lock only when the instance is new.
  Instance* find_or_add(const InstanceName<T>& name) noexcept {
    if (Instance* const found = find(name)) return found;
    if (instance_count_.load(std::memory_order_acquire) == kMaxInstances) return nullptr;
    const std::lock_guard lock{growing_};
    return find_or_add_locked(name);
  }

  /// For a Reader: the instance keeps its name from now on.
  Instance* find_or_add_to_keep(const InstanceName<T>& name) noexcept {
    const std::lock_guard lock{growing_};
    Instance* const instance = find_or_add_locked(name);
    if (instance) instance->kept = true;
    return instance;
  }

  /// The newest sample under that name. Wait-free, also while the instance gets another name.
  [[nodiscard]] std::optional<T> newest(const InstanceName<T>& name) noexcept {
    const Instance* const instance = find(name);
    if (!instance) return std::nullopt;
    if (!instance->looked_up.load(std::memory_order_relaxed)) {
      instance->looked_up.store(true, std::memory_order_relaxed);
    }
    const auto sample = instance->latest.read();
    if (!sample || instance_name(sample->value) != name) return std::nullopt;
    return sample->value;
  }

  Instance* find(const InstanceName<T>& name) noexcept {
    const std::size_t count = instance_count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i) {
      if (instances_[i].name == name) return &instances_[i];
    }
    return nullptr;
  }

  Inbox& subscribe(std::shared_ptr<Wakeup> wakeup, PublisherId except) {
    const std::lock_guard lock{growing_};
    const std::size_t count = inbox_count_.load(std::memory_order_relaxed);
    if (count == kMaxSubscriptions) {
      throw StartupError{std::string{TopicTraits<T>::name} + " has " + std::to_string(count) +
                         " subscriptions, which is all there is room for: subscribe once, at start-up"};
    }
    inboxes_[count] = std::make_unique<Inbox>();
    inboxes_[count]->except = except;
    inboxes_[count]->wakeup = std::move(wakeup);
    inbox_count_.store(count + 1, std::memory_order_release);
    return *inboxes_[count];
  }

  void release(PublisherId publisher) noexcept {
    for (Instance& instance : instances_) {
      PublisherId owner = publisher;
      instance.owner.compare_exchange_strong(owner, kNobody, std::memory_order_acq_rel);
    }
  }

  template <class F>
  void for_each_instance(F&& f) const {
    const std::size_t count = instance_count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i) f(instances_[i]);
  }

  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  static bool claim(Instance& instance, PublisherId publisher) noexcept {
    PublisherId owner = instance.owner.load(std::memory_order_acquire);
    return owner == publisher || (owner == kNobody && instance.owner.compare_exchange_strong(
                                                          owner, publisher, std::memory_order_acq_rel));
  }

  Instance* find_or_add_locked(const InstanceName<T>& name) noexcept {
    if (Instance* const found = find(name)) return found;
    const std::size_t count = instance_count_.load(std::memory_order_relaxed);
    if (count == kMaxInstances) return nullptr;
    instances_[count].name.set(name);
    instance_count_.store(count + 1, std::memory_order_release);
    return &instances_[count];
  }

  /// Gives the place of the stranger who was silent for longest to another. Whoever was looked up lately,
  /// such as he who holds the command, keeps his. Strangers' one thread.
  Instance* replace_for(const InstanceName<T>& name, PublisherId strangers) noexcept {
    const auto now = std::chrono::steady_clock::now();
    const bool look_through = now - looked_through_ >= kLookedUpLately;
    if (look_through) looked_through_ = now;
    const std::lock_guard lock{growing_};
    Instance* stalest = nullptr;
    for (Instance& instance : instances_) {
      if (instance.owner.load(std::memory_order_relaxed) != strangers) continue;
      if (look_through) instance.in_use = instance.looked_up.exchange(false, std::memory_order_relaxed);
      if (instance.kept || instance.in_use || instance.looked_up.load(std::memory_order_relaxed)) continue;
      if (!stalest || instance.written < stalest->written) stalest = &instance;
    }
    if (stalest) stalest->name.set(name);
    return stalest;
  }

  static constexpr Nanoseconds kLookedUpLately = 200ms;

  std::array<Instance, kMaxInstances> instances_{};
  std::atomic<std::size_t> instance_count_{0};
  std::array<std::unique_ptr<Inbox>, kMaxSubscriptions> inboxes_{};
  std::atomic<std::size_t> inbox_count_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::mutex growing_;
  std::uint64_t strangers_samples_ = 0;
  std::chrono::steady_clock::time_point looked_through_{};
};

}  // namespace detail

/// The right to publish a topic. Belongs to one thread, except for topics of which every sample counts
/// (`kEverySampleCounts`): those may be published from several. Owns each instance that it was first to
/// publish.
template <class T>
class Publisher {
 public:
  Publisher(Publisher&& other) noexcept
      : topic_{std::exchange(other.topic_, nullptr)}, identity_{std::exchange(other.identity_, {})} {}
  Publisher& operator=(Publisher&& other) noexcept {
    std::swap(topic_, other.topic_);
    std::swap(identity_, other.identity_);
    return *this;
  }
  ~Publisher() {
    if (topic_) topic_->release(identity_.id);
  }

  /// Hands the sample to every reader and subscription. Wait-free but for the first sample of an instance.
  /// @returns false, and nobody gets it, when the instance belongs to another publisher or the table is full
  bool publish(const T& sample) noexcept { return topic_->publish(sample, identity_); }

 private:
  friend class LocalBus;
  Publisher(detail::Topic<T>& topic, detail::PublisherIdentity identity)
      : topic_{&topic}, identity_{identity} {}

  detail::Topic<T>* topic_;
  detail::PublisherIdentity identity_;
};

/// Sees the newest sample of one instance. A value; each copy remembers what it has seen. Wait-free, one
/// thread each.
template <class T>
class Reader {
 public:
  /// The newest sample; nothing before the first.
  [[nodiscard]] std::optional<T> newest() const noexcept {
    const auto sample = instance_->latest.read();
    return sample ? std::optional<T>{sample->value} : std::nullopt;
  }
  /// The newest sample if it was not handed out by this before.
  [[nodiscard]] std::optional<T> newer() noexcept { return instance_->latest.read_newer(seen_); }

 private:
  friend class LocalBus;
  explicit Reader(const typename detail::Topic<T>::Instance& instance) : instance_{&instance} {}

  const typename detail::Topic<T>::Instance* instance_;
  std::uint64_t seen_ = 0;
};

/// Gets every sample of a topic, all instances, in the order of publishing. One thread. Ends with this
/// object; its place in the table stays taken, so subscribe at start-up, not per request.
template <class T>
class Subscription {
 public:
  Subscription(Subscription&& other) noexcept : inbox_{std::exchange(other.inbox_, nullptr)} {}
  Subscription& operator=(Subscription&& other) noexcept {
    std::swap(inbox_, other.inbox_);
    return *this;
  }
  ~Subscription() {
    if (inbox_) inbox_->open.store(false, std::memory_order_relaxed);
  }

  /// The oldest sample that was not taken yet; nothing when there is none.
  [[nodiscard]] std::optional<T> next() noexcept { return inbox_->queue.pop(); }
  /// Samples that did not fit because nobody took the older ones.
  [[nodiscard]] std::uint64_t lost() const noexcept { return inbox_->lost.load(std::memory_order_relaxed); }

 private:
  friend class LocalBus;
  explicit Subscription(typename detail::Topic<T>::Inbox& inbox) : inbox_{&inbox} {}

  typename detail::Topic<T>::Inbox* inbox_;
};

/// All topics of one process. Handles (Publisher, Reader, Subscription) must not outlive it.
class LocalBus {
 public:
  LocalBus() : topics_{std::make_unique<Topics>()} {}

  template <class T>
  [[nodiscard]] Publisher<T> advertise() {
    return Publisher<T>{of<T>(), {next_id_.fetch_add(1, std::memory_order_relaxed), false}};
  }

  /// For what comes in from outside: one of these a topic. When the table is full, a new instance takes the
  /// place of the one of its own that was written least lately, unless that one was looked up by name within
  /// the last fifth of a second or a Reader looks at it.
  template <class T>
  [[nodiscard]] Publisher<T> advertise_for_strangers() {
    return Publisher<T>{of<T>(), {next_id_.fetch_add(1, std::memory_order_relaxed), true}};
  }

  /// Looks at one instance, which need not exist yet: `reader<topic::Mru>("mru1")`,
  /// `reader<topic::Bodies>("qualisys", "load")`, `reader<topic::Estimate>()`.
  template <class T, class... Names>
  [[nodiscard]] Reader<T> reader(const Names&... names) {
    static_assert(!kEverySampleCounts<T>, "of this topic every sample counts: subscribe to it");
    static_assert(sizeof...(Names) == detail::key_count<T>(), "name every key field of the topic, in order");
    const auto* const instance = of<T>().find_or_add_to_keep(detail::InstanceName<T>{Text<32>{names}...});
    if (!instance) {
      throw StartupError{std::string{TopicTraits<T>::name} + " has no room for another instance: at most " +
                         std::to_string(detail::Topic<T>::kMaxInstances) + " can be told apart"};
    }
    return Reader<T>{*instance};
  }

  /// @param wakeup  rung on every sample; may be null
  /// @param except  whose samples are left out; may be null
  template <class T>
  [[nodiscard]] Subscription<T> subscribe(std::shared_ptr<Wakeup> wakeup = nullptr,
                                          const Publisher<T>* except = nullptr) {
    return Subscription<T>{
        of<T>().subscribe(std::move(wakeup), except ? except->identity_.id : detail::kNobody)};
  }

  /// The newest sample of an instance, which need not be known before; nothing when there is none. Wait-free.
  template <class T, class... Names>
  [[nodiscard]] std::optional<T> newest(const Names&... names) const noexcept {
    static_assert(!kEverySampleCounts<T>, "of this topic every sample counts: subscribe to it");
    static_assert(sizeof...(Names) == detail::key_count<T>(), "name every key field of the topic, in order");
    return of<T>().newest(detail::InstanceName<T>{Text<32>{names}...});
  }

  /// Calls f(sample) with the newest sample of every instance that has one.
  template <class T, class F>
  void for_each_newest(F&& f) const {
    static_assert(!kEverySampleCounts<T>, "of this topic every sample counts: subscribe to it");
    of<T>().for_each_instance([&f](const auto& instance) {
      if (const auto sample = instance.latest.read()) f(sample->value);
    });
  }

  /// Samples that were refused because their instance belongs to another publisher or the table is full.
  template <class T>
  [[nodiscard]] std::uint64_t refused() const noexcept {
    return of<T>().refused();
  }

 private:
  template <class T>
  [[nodiscard]] detail::Topic<T>& of() const noexcept {
    return std::get<detail::Topic<T>>(topics_->all);
  }

  struct None {};
  struct Topics {
#define MOTIONLAB_TOPIC(Type) , detail::Topic<topic::Type>
    std::tuple<None MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_TOPIC)> all;
#undef MOTIONLAB_TOPIC
  };

  std::unique_ptr<Topics> topics_;
  std::atomic<detail::PublisherId> next_id_{detail::kNobody + 1};
};

}  // namespace motionlab::bus
