/// @file  What is in an MCAP file, what is missing, and a whole file of what is good.
#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/record/mcap_reader.hpp"
#include "gateway/record/sequence_ledger.hpp"

namespace motionlab::record {

/// Added to a repaired file: what was wrong with the old one.
inline constexpr std::string_view kRepairMetadata = "motionlab/repair";

struct TopicContents {
  std::string topic;
  std::string type;  ///< empty: the file has no schema for it
  std::uint64_t messages = 0;
  std::uint64_t first_ns = 0, last_ns = 0;  ///< when they were logged
  SequenceLedger numbers;                   ///< of the messages; exact when one writer wrote them all
};

struct Damage {
  std::uint64_t position;  ///< behind the damaged record, in bytes from the front
  std::string_view text;
};

struct Inspection {
  std::string library;
  std::vector<TopicContents> topics;  ///< in the order of their first messages
  std::vector<McapMetadata> metadata;
  std::vector<std::pair<std::string, std::size_t>> attachments;  ///< name, bytes
  std::vector<Damage> damages;                                   ///< the first `kMaxDamages`
  std::uint64_t damage_count = 0;
  bool complete = false;   ///< it has its end
  bool has_index = false;  ///< and an index

  static constexpr std::size_t kMaxDamages = 20;

  [[nodiscard]] bool whole() const noexcept { return complete && has_index && damage_count == 0; }
  [[nodiscard]] std::uint64_t messages() const noexcept;
};

/// Reads all of a file. Whatever the bytes are, it comes to an end.
[[nodiscard]] Inspection inspect(std::istream& in);

/// Likewise, and writes a whole file of all that is good in it.
[[nodiscard]] Inspection repair(std::istream& in, std::ostream& out);

}  // namespace motionlab::record
