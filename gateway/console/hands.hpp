/// @file  `Hands`: what the console may ask of the gateway. The gateway decides.
#pragma once

#include <string>
#include <string_view>

#include "drivers/core/time.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "idl/mode_request.hpp"
#include "idl/reference.hpp"

namespace motionlab::console {

/// Puts requests and references on DDS. Who asks, when and with which number is said here, whatever a client
/// says. One thread.
class Hands {
 public:
  /// @param requester  who asks, for the gateway's log
  /// @throws StartupError  as DdsBus
  Hands(const bus::DdsConfig& config, const Clock& clock, std::string requester);

  /// Asks for rest now and, because a gateway that has just come may not have heard it, every 20 ms for a
  /// second.
  void settle();
  /// Repeats what has to be repeated. Often.
  void run(LabTime now);

  /// Whether clients may publish on this topic.
  [[nodiscard]] static bool may_publish(std::string_view topic);
  /// Publishes a client's message: JSON with names of the IDL. @throws std::invalid_argument with a sentence
  void publish(std::string_view topic, std::string_view json);

 private:
  template <class T>
  void stamp(T& sample);

  const Clock& clock_;
  const std::string requester_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Publisher<topic::ModeRequest> requests_;
  bus::Publisher<topic::Reference> references_;
  topic::ModeRequest settle_;
  LabTime settle_until_{}, settle_next_{};
};

}  // namespace motionlab::console
