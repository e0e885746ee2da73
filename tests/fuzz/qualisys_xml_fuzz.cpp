// The XML of both ends: a server's lists and a master's settings. What was read must survive being written.
#include <cstdint>
#include <cstdlib>

#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  using namespace motionlab::qualisys;
  const std::string_view text = as_text({data, size});
  (void)parse_settings_xml(text);
  const auto bodies = parse_bodies_xml(text);
  if (!bodies) return 0;
  if (bodies->size() > kMaxBodies) std::abort();
  for (const int version : {20, 25}) {
    const auto again = parse_bodies_xml(
        write_parameters_xml({.version_minor = version, .bodies = true, .body_list = *bodies}));
    if (!again || again->size() != bodies->size()) std::abort();
  }
  return 0;
}
