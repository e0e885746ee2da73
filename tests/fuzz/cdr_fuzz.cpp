// Any bytes as a sample of any topic, the first byte saying which: it is refused, or it is within what the
// IDL and the topic allow and comes back the same from the bytes that its values make.
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string_view>
#include <type_traits>
#include <vector>

#include "gateway/bus/cdr_reader.hpp"

namespace {

using namespace motionlab;
using namespace motionlab::bus;

/// The bytes of a sample by the rules of CDR, written for this test alone.
class WriteField {
 public:
  explicit WriteField(eprosima::fastcdr::Cdr& cdr) : cdr_{cdr} {}
  template <class Value>
  void operator()(std::string_view, const Value& value) {
    write(value);
  }

 private:
  template <class Value>
  void write(const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      cdr_ << static_cast<std::uint32_t>(value);
    } else {
      cdr_ << value;
    }
  }
  template <std::size_t N>
  void write(const Text<N>& text) {
    cdr_ << text.str();
  }
  template <class Value, std::size_t N>
  void write(const std::array<Value, N>& values) {
    for (const Value& value : values) write(value);
  }
  eprosima::fastcdr::Cdr& cdr_;
};

template <class T>
std::vector<char> bytes_of(const T& sample) {
  eprosima::fastcdr::FastBuffer buffer;
  eprosima::fastcdr::Cdr cdr{buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS,
                             eprosima::fastcdr::Cdr::DDS_CDR};
  cdr.serialize_encapsulation();
  T::fields(sample, WriteField{cdr});
  return {buffer.getBuffer(), buffer.getBuffer() + cdr.getSerializedDataLength()};
}

template <class T>
void read_and_write(const std::uint8_t* data, std::size_t size) {
  std::vector<char> bytes{data, data + size};
  T sample;
  if (read_cdr(bytes.data(), bytes.size(), sample) != Refusal::none) return;
  std::vector<char> written = bytes_of(sample);
  T again;
  if (read_cdr(written.data(), written.size(), again) != Refusal::none) std::abort();
  if (bytes_of(again) != written) std::abort();
}

using Reader = void (*)(const std::uint8_t*, std::size_t);
#define MOTIONLAB_READER(Type) read_and_write<topic::Type>,
constexpr Reader kReaders[] = {MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_READER)};
#undef MOTIONLAB_READER

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) kReaders[data[0] % std::size(kReaders)](data + 1, size - 1);
  return 0;
}
