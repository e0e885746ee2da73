#include "gateway/bus/security.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "drivers/core/error.hpp"

namespace motionlab::bus {
namespace {

constexpr const char* kPrivateKey = "key.pem";

struct Property {
  const char* name;
  const char* file;
};
constexpr std::array kFiles{
    Property{"dds.sec.auth.builtin.PKI-DH.identity_ca", "authority.pem"},
    Property{"dds.sec.auth.builtin.PKI-DH.identity_certificate", "certificate.pem"},
    Property{"dds.sec.auth.builtin.PKI-DH.private_key", kPrivateKey},
    Property{"dds.sec.access.builtin.Access-Permissions.permissions_ca", "authority.pem"},
    Property{"dds.sec.access.builtin.Access-Permissions.governance", "governance.smime"},
    Property{"dds.sec.access.builtin.Access-Permissions.permissions", "permissions.smime"},
};

/// Fast DDS itself only says that it does not start.
void check(const std::filesystem::path& file) {
  if (::access(file.c_str(), R_OK) != 0) {
    throw StartupError{"DDS security: " + file.string() + " cannot be read: " + std::strerror(errno) +
                       "; deploy/security/identities.sh makes such a folder"};
  }
  struct stat status {};
  if (file.filename() == kPrivateKey && ::stat(file.c_str(), &status) == 0 &&
      (status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw StartupError{"DDS security: the private key " + file.string() +
                       " can be read by others than its owner: chmod 600 " + file.string()};
  }
}

}  // namespace

void set_security(eprosima::fastdds::dds::DomainParticipantQos& qos, const std::string& folder) {
  auto& properties = qos.properties().properties();
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  for (const auto& [name, file] : kFiles) {
    const std::filesystem::path path = std::filesystem::absolute(folder) / file;
    check(path);
    properties.emplace_back(name, "file://" + path.string());
  }
}

}  // namespace motionlab::bus
