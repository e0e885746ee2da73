#include "simulators/lab/study/fault_matrix_command.hpp"

#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

#include "drivers/core/error.hpp"
#include "simulators/lab/fault_matrix/table.hpp"
#include "simulators/lab/study/fault_matrix_run.hpp"
#include "simulators/lab/study/option_words.hpp"

namespace motionlab::study {

namespace {

constexpr const char* kMatrix = "--fault-matrix";

matrix::Matrix read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw StartupError("cannot read " + path + "; name a report of --fault-matrix");
  return matrix::from_json({std::istreambuf_iterator<char>(file), {}});
}

void write(const std::string& text, const std::string& path) {
  if (path.empty()) {
    std::cout << text;
    return;
  }
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush())
    throw StartupError("cannot write " + path + "; choose a folder that exists and is writable");
}

}  // namespace

void FaultMatrixWords::add_to(CLI::App& app) {
  CLI::Option* const matrix = app.add_flag(
      kMatrix, run, "run every fault of every device while settled, engaged calm and engaged in a sea");
  app.add_option("--only", only, "this DEVICE or DEVICE:FAULT alone")->needs(matrix);
  app.add_option("--recorded", recorded, "take this report instead of running anything")->needs(matrix);
  app.add_option("--bounds", bounds, "fail where it is worse than in this report")->needs(matrix);
  app.add_flag("--markdown", markdown, "write the tables for people instead of JSON")->needs(matrix);
}

int fault_matrix(const CLI::App& app, const LabRun& base, const FaultMatrixWords& words,
                 const std::string& report) {
  allow_only(app, "fault-matrix", kMatrix,
             {"only", "recorded", "bounds", "markdown", "report", "seed", "set", "config", "world-config"});
  const matrix::Matrix entries =
      words.recorded.empty() ? run_fault_matrix(base, words.only) : read(words.recorded);
  write(words.markdown ? to_markdown(entries) : to_json(entries), report);
  std::vector<std::string> wrong = offences(entries);
  if (!words.bounds.empty()) {
    const auto worse = matrix::worse(entries, read(words.bounds));
    wrong.insert(wrong.end(), worse.begin(), worse.end());
  }
  for (const std::string& sentence : wrong) std::cerr << sentence << '\n';
  return wrong.empty() ? 0 : 1;
}

}  // namespace motionlab::study
