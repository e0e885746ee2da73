// What our reader and decoder make of a recording, one line of JSON a message, for a stranger to compare with
// its own:
//   interop_mcap_dump record FILE     records a short run
//   interop_mcap_dump decode FILE     decodes it
// Whole numbers of 64 bits are texts, numbers that are none are "nan" and so on.
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "drivers/core/config_path.hpp"
#include "gateway/record/cdr.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "idl/snapshot.hpp"
#include "idl/topics.hpp"
#include "simulators/lab/lockstep/lockstep.hpp"

namespace {

using namespace motionlab;

class Json {
 public:
  template <class Value>
  void operator()(std::string_view name, const Value& value) {
    text_ += (text_.back() == '{' ? "\"" : ",\"") + std::string(name) + "\":";
    write(value);
  }
  template <class T>
  static std::string of(const T& sample) {
    Json json;
    json.write(sample);
    return json.text_;
  }

 private:
  template <class Value>
  void write(const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      text_ += std::to_string(static_cast<std::uint32_t>(value));
    } else if constexpr (std::is_same_v<Value, bool>) {
      text_ += value ? "true" : "false";
    } else if constexpr (std::is_floating_point_v<Value>) {
      char digits[32];
      const char* const end = std::to_chars(digits, digits + sizeof digits, value).ptr;
      const std::string number(std::string_view(digits, static_cast<std::size_t>(end - digits)));
      text_ += std::isfinite(value) ? number : '"' + number + '"';
    } else if constexpr (std::is_arithmetic_v<Value>) {
      text_ += sizeof(Value) == 8 ? '"' + std::to_string(value) + '"' : std::to_string(value);
    } else {
      text_ += '{';
      Value::fields(value, *this);
      text_ += '}';
    }
  }
  template <std::size_t N>
  void write(const Text<N>& text) {
    text_ += '"';
    for (const char c : text.view()) {
      if (c == '"' || c == '\\') text_ += '\\';
      text_ += c;
    }
    text_ += '"';
  }
  template <class Value, std::size_t N>
  void write(const std::array<Value, N>& values) {
    write_each(values);
  }
  template <class Value, std::size_t N>
  void write(const Sequence<Value, N>& values) {
    write_each(values);
  }
  template <class Values>
  void write_each(const Values& values) {
    text_ += '[';
    for (const auto& value : values) {
      if (text_.back() != '[') text_ += ',';
      write(value);
    }
    text_ += ']';
  }

  std::string text_;
};

template <class T>
void print(const record::McapMessage& message) {
  static T sample;
  sample = T{};
  if (!record::read_cdr(message.data, sample, record::kDdsPadding))
    throw std::runtime_error("a sample that is none");
  std::cout << "{\"topic\":\"" << message.channel->topic << "\",\"sequence\":" << message.sequence
            << ",\"log_time\":\"" << message.logged_ns << "\",\"publish_time\":\"" << message.published_ns
            << "\",\"sample\":" << Json::of(sample) << "}\n";
}

void print_any(const record::McapMessage& message) {
  const std::string& type = message.channel->schema->name;
#define MOTIONLAB_PRINT(Type) \
  if (type == topic::Type::kTypeName) return print<topic::Type>(message);
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_PRINT)
  MOTIONLAB_PRINT(Snapshot)
#undef MOTIONLAB_PRINT
  throw std::runtime_error("a type that is none of the house");
}

int decode(const char* file) {
  std::ifstream in(file, std::ios::binary);
  record::McapReader reader(in);
  for (;;) {
    const auto item = reader.next();
    if (!item) {
      std::cerr << item.fault().text << '\n';
      return 1;
    }
    if (!item->has_value()) return reader.complete() ? 0 : 1;
    if (const auto* const message = std::get_if<record::McapMessage>(&**item)) print_any(*message);
  }
}

/// Long enough to be engaged, with every kind of request on the way.
int record_run(const char* file) {
  lockstep::Config config;
  config.gateway = service::load_gateway_config(find_config("lab.toml"), {find_config("loopback.toml")});
  config.gateway.record.inputs = file;
  config.gateway.record.outputs_every = 10;
  config.lab = lab::LabConfig::load(find_config("world.toml"));
  config.lab.set_scenario("sea");
  lockstep::Lockstep line(config);
  auto references = line.bus().advertise<topic::Reference>();
  while (line.now() < LabTime{} + 5s) {
    if (line.now() == LabTime{} + 3s) line.request(topic::ModeAction::engage);
    if (line.now() == LabTime{} + 4s) {
      topic::Reference reference;
      reference.requester = "a \"stranger\"";
      reference.p_world_load_m = {0.85, -0.4, std::numeric_limits<double>::quiet_NaN()};
      references.publish(reference);
    }
    line.step();
  }
  line.finish_recording();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3 && std::string_view(argv[1]) == "record") return record_run(argv[2]);
    if (argc == 3 && std::string_view(argv[1]) == "decode") return decode(argv[2]);
    std::cerr << "usage: interop_mcap_dump record|decode FILE\n";
    return 64;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
