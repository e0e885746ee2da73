/// @file  How Fast DDS handles the plain structs: generated code writes the bytes and makes the key, ours
/// reads. Seen by dds_bus.cpp and its tests alone.
#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

#include <twins/every.hpp>

#include "gateway/bus/cdr_reader.hpp"
#include "gateway/bus/convert.hpp"
#include "gateway/bus/topics.hpp"

namespace motionlab::bus {

/// What fastddsgen made of the same .idl file. Constructing a twin registers its type with Fast DDS.
template <class T>
struct TwinOf;

#define MOTIONLAB_TWIN(Type)                     \
  template <>                                    \
  struct TwinOf<topic::Type> {                   \
    using Twin = motionlab::Type;                \
    using Support = motionlab::Type##PubSubType; \
  };
MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_TWIN)
#undef MOTIONLAB_TWIN

/// What Fast DDS hands to and fro: the sample, and on the way in whether it may be believed.
template <class T>
struct Carried {
  T sample{};
  Refusal refusal = Refusal::none;
};

/// Works on `Carried<T>`. One object serves all endpoints of its type, from the bus thread and the receive
/// threads: the generated key maker has one buffer for all and is therefore behind a lock. The twin is kept,
/// because each construction of a twin registers its type again, with locks and allocations.
template <class T>
class TypeSupport : public TwinOf<T>::Support {
 public:
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;
  using Handle = eprosima::fastrtps::rtps::InstanceHandle_t;

  TypeSupport() {
    this->auto_fill_type_object(true);
    this->auto_fill_type_information(false);  // Cyclone refuses an endpoint that announces it
  }

  bool serialize(void* data, Payload* payload) override {
    const std::lock_guard lock{mutex_};
    try {
      to_twin(static_cast<const Carried<T>*>(data)->sample, twin_);
      return TwinOf<T>::Support::serialize(&twin_, payload);
    } catch (const std::exception&) {
      return false;
    }
  }

  /// Always succeeds: a refused sample is delivered with its refusal and counted where it is taken.
  bool deserialize(Payload* payload, void* data) override {
    auto& carried = *static_cast<Carried<T>*>(data);
    carried.refusal = read_cdr(reinterpret_cast<char*>(payload->data), payload->length, carried.sample);
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [this] { return this->m_typeSize; };
  }

  bool getKey(void* data, Handle* handle, bool force_md5 = false) override {
    const std::lock_guard lock{mutex_};
    try {
      to_twin(static_cast<const Carried<T>*>(data)->sample, twin_);
      return TwinOf<T>::Support::getKey(&twin_, handle, force_md5);
    } catch (const std::exception&) {
      return false;
    }
  }

  void* createData() override { return new Carried<T>{}; }
  void deleteData(void* data) override { delete static_cast<Carried<T>*>(data); }

 private:
  std::mutex mutex_;
  typename TwinOf<T>::Twin twin_;
};

/// A sample together with the bytes that it came in.
template <class T>
struct Tapped : Carried<T> {
  std::vector<std::byte> bytes;  ///< encapsulation header first, exactly as they came
};

/// Works on `Tapped<T>`, for readers only. The sample is read for its key and its refusal; the bytes are
/// kept.
template <class T>
class TapSupport final : public TypeSupport<T> {
 public:
  bool deserialize(typename TypeSupport<T>::Payload* payload, void* data) override {
    auto& tapped = static_cast<Tapped<T>&>(*static_cast<Carried<T>*>(data));
    const auto* const begin = reinterpret_cast<const std::byte*>(payload->data);
    tapped.bytes.assign(begin, begin + payload->length);
    return TypeSupport<T>::deserialize(payload, data);
  }
  void* createData() override { return static_cast<Carried<T>*>(new Tapped<T>{}); }
  void deleteData(void* data) override { delete static_cast<Tapped<T>*>(static_cast<Carried<T>*>(data)); }
};

}  // namespace motionlab::bus
