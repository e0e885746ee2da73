#include "gateway/record/run_recorder.hpp"

#include <cerrno>
#include <cstring>

#include "drivers/core/error.hpp"
#include "idl/schemas.hpp"

namespace motionlab::record {

RunRecorder::RunRecorder(const std::filesystem::path& file, RunTape& tape, std::string_view configuration,
                         int zstd_level)
    : file_(file),
      tape_(tape),
      out_(file, std::ios::binary | std::ios::trunc),
      writer_(out_, {.profile = {}, .library = "motionlab " MOTIONLAB_VERSION, .zstd_level = zstd_level}) {
  if (!out_) {
    throw StartupError("cannot write the recording " + file.string() + ": " + std::strerror(errno) +
                       "; choose a folder that exists and is writable");
  }
  writer_.metadata(kRunMetadata,
                   {{"version", MOTIONLAB_VERSION}, {"outputs_every", std::to_string(tape.outputs_every())}});
  writer_.attachment(kRunConfiguration, "application/toml", LabTime{}, as_bytes(configuration));
  for (RunKind kind = 0; kind < kRunKinds; ++kind) {
    for_run_type(kind, [&]<class T>() {
      channels_[kind] = writer_.add_channel(run_topic<T>(), "cdr",
                                            writer_.add_schema(T::kTypeName, "omgidl", topic::kSchema<T>));
    });
  }
}

void RunRecorder::note_gap(std::uint64_t lost, std::uint64_t before_step) {
  writer_.end_chunk();  // so that the file says it where it is
  writer_.metadata(kGapMetadata,
                   {{"lost_steps", std::to_string(lost)}, {"before_step", std::to_string(before_step)}});
}

std::size_t RunRecorder::drain() {
  std::size_t steps = 0;
  while (tape_.ring().pop(step_)) {
    ++steps;
    StepHead head;
    std::memcpy(&head, step_.data(), sizeof head);
    const LabTime t = from_ns(head.t_ns);
    if (head.lost != lost_) note_gap(head.lost - lost_, head.step);
    lost_ = head.lost;
    if (chunk_begun_ && t - *chunk_begun_ >= kChunk) {
      writer_.end_chunk();
      chunk_begun_.reset();
    }
    if (!chunk_begun_) chunk_begun_ = t;
    (void)for_each_sample(step_, [&](RunKind kind, Bytes cdr) {
      writer_.message(channels_[kind], counts_[kind]++, t, t, cdr);
    });
    steps_ = head.step;
  }
  return steps;
}

void RunRecorder::finish() {
  (void)drain();
  if (const std::uint64_t lost = tape_.lost(); lost != lost_)
    note_gap(lost - lost_, steps_ + lost - lost_ + 1);
  writer_.finish();
  out_.close();
}

std::optional<std::string> RunRecorder::trouble() const {
  if (writer_.ok()) return std::nullopt;
  return full(file_);
}

std::string RunRecorder::full(const std::filesystem::path& file) {
  return "the recording " + file.string() + " ends early: its disk takes no more; make room and start again";
}

std::filesystem::path unused_name(const std::filesystem::path& file) {
  std::filesystem::path name = file;
  for (int number = 2; std::filesystem::exists(name); ++number) {
    name = file.parent_path() /
           (file.stem().string() + "-" + std::to_string(number) + file.extension().string());
  }
  return name;
}

}  // namespace motionlab::record
