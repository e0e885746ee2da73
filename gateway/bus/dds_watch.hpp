/// @file  `DdsWatch`: who is on the bus and what they say, with everything that DDS knows about each sample.
/// Only listens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/bus/dds_config.hpp"
#include "gateway/bus/dds_id.hpp"
#include "gateway/bus/refusal.hpp"
#include "gateway/bus/wakeup.hpp"

namespace motionlab::bus {

/// As DDS orders it: who offers more also satisfies who asks for less.
enum class Durability : std::uint8_t { not_kept, transient_local, transient, persistent };
[[nodiscard]] std::string_view to_string(Durability durability) noexcept;  ///< in DDS' words: "volatile", …

/// What an endpoint offers or asks for.
struct SeenQos {
  bool reliable = false;
  Durability durability = Durability::not_kept;
  bool exclusive = false;               ///< ownership
  bool xcdr1 = true;                    ///< the encoding that this house reads and writes
  double deadline_s = 0;                ///< 0: none
  std::vector<std::string> partitions;  ///< empty: the default one
  bool operator==(const SeenQos&) const = default;
};

/// A writer or reader somewhere. All texts come from strangers: they may be long and hold any byte.
struct SeenEndpoint {
  DdsId id;
  bool writes = false;
  std::string topic;
  std::string type;
  SeenQos qos;
  std::string participant;  ///< its name; may be empty
  std::string host;         ///< the host's name, where it was told; else its address; else empty
  std::string process;      ///< process number; empty where it was not told
};

struct SeenParticipant {
  DdsId id;
  std::string name;
  std::string host;
  std::string process;
};

/// What a reader must ask for so that each of these writers matches: the strongest that all of them offer, in
/// all of their partitions. Without writers: the weakest, in the default partition.
[[nodiscard]] SeenQos satisfied_by_all(const std::vector<SeenEndpoint>& writers);

/// One sample as it arrived. Stamps are in ns since 1970 by the system clock of the writer's and of this
/// host.
template <class T>
struct Heard {
  T sample{};
  Refusal refusal =
      Refusal::none;  ///< else the sample is not to be believed; what could be read is filled in
  bool data = true;   ///< false: only a sign that a writer or an instance has left
  DdsId writer;
  std::uint64_t writer_sequence = 0;  ///< +1 per sample of this writer, over all instances
  std::int64_t t_written_ns = 0;      ///< DDS source timestamp
  std::int64_t t_heard_ns = 0;        ///< DDS reception timestamp
};

/// A participant that only listens: it discovers everybody in the domain, every partition included, and hears
/// the topics it is asked to. Strangers cannot end the process: what they send is bounds-checked and their
/// number bounded.
class DdsWatch {
 public:
  /// Begins to discover. `join_truth` is of no importance here.
  /// @throws StartupError  with advice: unknown interface, bad domain, no participant
  explicit DdsWatch(const DdsConfig& config, std::shared_ptr<Wakeup> wakeup = nullptr);
  ~DdsWatch();
  DdsWatch(const DdsWatch&) = delete;
  DdsWatch& operator=(const DdsWatch&) = delete;

  /// Everybody else who is there now, in the order of their ids.
  [[nodiscard]] std::vector<SeenParticipant> participants() const;
  /// All their writers and readers. A participant may be known a moment before its endpoints, and the
  /// reverse.
  [[nodiscard]] std::vector<SeenEndpoint> endpoints() const;
  [[nodiscard]] std::vector<SeenEndpoint> writers_of(std::string_view topic) const;

  template <class T>
  class Tap;

  /// Hears a topic under this name from now on, from every writer of type T that is there or comes later: the
  /// reader asks for no more than all of them offer, and is made anew, weaker, when a later one offers less.
  /// @throws StartupError  DDS refuses the topic, e.g. because it is heard already with another type
  template <class T>
  [[nodiscard]] Tap<T> hear(const std::string& topic);

 private:
  struct Impl;
  template <class T>
  class Ear;
  std::unique_ptr<Impl> impl_;
};

/// The samples of one topic, in the order of arrival. They wait in a queue, however long nobody looks, up to
/// `kQueueDepth`. One thread; must not outlive its watch.
template <class T>
class DdsWatch::Tap {
 public:
  static constexpr std::size_t kQueueDepth = 16384;

  Tap(Tap&&) noexcept;
  Tap& operator=(Tap&&) noexcept;
  ~Tap();

  [[nodiscard]] std::optional<Heard<T>> next();
  /// Samples that found the queue full. They are missing here, not on the bus.
  [[nodiscard]] std::uint64_t overflowed() const;

 private:
  friend class DdsWatch;
  explicit Tap(std::unique_ptr<Ear<T>> ear);
  std::unique_ptr<Ear<T>> ear_;
};

}  // namespace motionlab::bus
