/// @file  `DelayMeter`: where the time goes between a device's measurement and a reader on the bus, hop by
/// hop.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/monitor/any_tap.hpp"
#include "gateway/monitor/percentiles.hpp"
#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {

/// In the order of the way.
enum class Hop : std::uint8_t {
  link,       ///< measured -> received: the device and its link
  snapshot,   ///< received -> the control step that used it
  actuation,  ///< measured -> that control step: the age of the data behind a command
  estimate,   ///< the time of the estimate -> computed
  control,    ///< snapshot -> guard
  publish,    ///< the sample's last own stamp -> DDS source timestamp
  network,    ///< DDS source timestamp -> heard here
  count_
};

/// "measured -> received", …
[[nodiscard]] std::string_view name_of(Hop hop) noexcept;
/// Whether the hop compares laboratory time or a writer's clock with another clock.
[[nodiscard]] constexpr bool crosses_clocks(Hop hop) noexcept {
  return hop == Hop::publish || hop == Hop::network;
}

struct HopDelay {
  Hop hop{};
  std::string what;  ///< a device, a source of the control step, or a topic
  Percentiles delay_us;
  std::size_t negative = 0;  ///< samples whose stamps are in the wrong order: the clocks disagree
};

/// Everything is read from stamps in the samples and from DDS source timestamps. Keeps what it was fed with:
/// for minutes, not for days.
class DelayMeter {
 public:
  /// @param topic  the description of the sample's topic
  void take(const TopicDescription& topic, const HeardSample& sample);
  [[nodiscard]] bool empty() const noexcept { return delays_.empty(); }
  /// In the order of the way.
  [[nodiscard]] std::vector<HopDelay> report() const;

 private:
  struct Step {
    std::string source;  ///< "mru", as in age_mru_s
    std::int64_t t_snapshot_ns;
    std::int64_t t_measured_ns;
  };
  using Key = std::pair<Hop, std::string>;

  void add(Hop hop, std::string what, std::int64_t delay_ns);
  void take_control(const TopicDescription& topic, const HeardSample& sample);

  std::map<Key, std::vector<double>> delays_;
  /// Of each topic that a control step uses: measured -> received.
  std::map<std::string_view, std::map<std::int64_t, std::int64_t>> received_;
  std::vector<Step> steps_;
};

}  // namespace motionlab::monitor
