#include <sys/resource.h>
#include <tbb/global_control.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <future>
#include <thread>

#include "cli/build_facts.h"
#include "cli/commands.h"
#include "cli/part_file.h"
#include "cli/plan_plies.h"
#include "cli/run_report.h"
#include "cli/signals.h"
#include "cli/terminal.h"
#include "geometry/error.h"
#include "io/coverage_csv.h"
#include "io/output_directory.h"
#include "io/paths_csv.h"
#include "io/paths_step.h"
#include "io/plies_csv.h"
#include "io/step/sha256.h"
#include "io/summary_json.h"
#include "io/text_file.h"
#include "io/tows_csv.h"

namespace afptraj::cli {
namespace {

// Times the stages of a run, one after the other.
class Stopwatch {
 public:
  explicit Stopwatch(bool verbose) : verbose_(verbose) {}
  void done(const std::string& stage) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    times_.push_back({stage, seconds});
    if (verbose_) print_note(stage + ": " + short_number(seconds * 1000, 3) + " ms");
    last_ = now;
  }
  double total() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  const std::vector<StageTime>& times() const { return times_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now(), last_ = start_;
  std::vector<StageTime> times_;
  bool verbose_;
};

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

// The job file with the flags over it.
Job assemble_job(const Arguments& arguments) {
  Job job = arguments.job.empty() ? Job{} : read_job(arguments.job);
  bool chooses_faces = false;
  for (const JobFlag& flag : arguments.job_flags) {
    chooses_faces = chooses_faces || flag.key == "faces.list" || flag.key == "faces.name" ||
                    flag.key == "faces.tangent_from";
  }
  if (chooses_faces) {
    // a choice on the command line replaces that of the file, of whatever kind it is
    const double angle = job.faces.tangent_angle_rad;
    job.faces = {};
    job.faces.tangent_angle_rad = angle;
  }
  for (const JobFlag& flag : arguments.job_flags) set_job_key(job, flag.key, flag.text, flag.flag);
  check_job(job, arguments.job.empty() || chooses_faces ? "command line" : arguments.job);
  return job;
}

std::string output_path(const Arguments& arguments, const Job& job) {
  if (!job.output_directory.empty()) return job.output_directory;
  return std::filesystem::path(arguments.part).stem().string() + "-afptraj";
}

std::vector<InputRecord> input_records(const Arguments& arguments, const StepModel& model) {
  constexpr std::size_t any_size = std::size_t{1} << 40;
  std::vector<InputRecord> records{
      {"part", arguments.part, model.sha256},
      {"plies", arguments.plies, sha256_hex(read_file(arguments.plies, any_size))}};
  if (!arguments.job.empty()) {
    records.push_back(
        {"job", arguments.job, sha256_hex(read_file(arguments.job, any_size, ErrorCode::usage))});
  }
  return records;
}

void write_paths_step(OutputDirectory& output, const std::vector<StepWire>& wires) {
  try {
    write_step(output.staging() / "paths.step", wires);
  } catch (const Error& e) {
    // the writer knows the temporary place only
    if (e.code() != ErrorCode::cannot_write) throw;
    throw Error(e.code(), (output.target() / "paths.step").string(), e.what());
  }
  output.adopt("paths.step");
}

}  // namespace

int run(const Arguments& arguments) {
  Stopwatch watch(arguments.verbose);
  RunRecord record;
  record.started = utc_now();
  record.versions = versions();
  record.job = assemble_job(arguments);
  record.job.plan.plies_name = arguments.plies;
  const std::string target = output_path(arguments, record.job);
  std::vector<std::filesystem::path> inputs{arguments.part, arguments.plies};
  if (!arguments.job.empty()) inputs.emplace_back(arguments.job);
  require_readable_file(arguments.part);
  PliesFile plies_file = read_plies_file(arguments.plies);
  check_output(target, arguments.force, inputs);
  watch.done("read plies");

  const StepModel model = read_part(arguments.part, record.job);
  for (const std::string& warning : model.warnings)
    record.warnings.push_back(arguments.part + ": " + warning);
  for (const std::string& warning : plies_file.warnings)
    record.warnings.push_back(arguments.plies + ": " + warning);
  record.inputs = input_records(arguments, model);
  watch.done("read part");

  // Threads start here: the importer forks before.
  record.threads = arguments.threads > 0
                       ? arguments.threads
                       : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(record.threads));
  const auto part = std::make_shared<const Part>(model.part);
  const ChosenFaces chosen = choose_faces(part, record.job.faces, plies_file.plies);
  record.faces_reason = chosen.reason;
  const Skin skin(part, chosen.faces);
  if (!arguments.quiet) {
    for (const std::string& warning : record.warnings) print_note("afptraj: warning: " + warning);
  }
  check_stop();
  watch.done("build skin");

  const std::vector<Ply> plies = plan_plies(skin, plies_file.plies, arguments, record.job);
  for (const Ply& ply : plies) record.violations.emplace_back(ply.name, limit_violations(ply, record.job));
  watch.done("plan");

  const std::vector<StepWire> wires = path_wires(skin, plies);
  check_stop();
  watch.done("fit paths");
  OutputDirectory output(target, arguments.force, inputs);
  auto csv = std::async(std::launch::async, [&] { 
    output.write("paths.csv", paths_csv(plies));
    output.write("tows.csv", [&](const TextSink& sink) { tows_csv(plies, sink); });
    if (arguments.coverage) output.write("coverage.csv", coverage_csv(plies));
  });
  write_paths_step(output, wires);
  csv.get();
  check_stop();
  watch.done("write paths");
  record.times = watch.times();
  record.times.push_back({"total", watch.total()});
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  record.peak_memory_mb = static_cast<double>(usage.ru_maxrss) / 1000;
  const std::string summary = summary_json(record, model, skin, plies);
  output.write("summary.json", summary);
  output.commit();

  bool violated = false;
  std::string text;
  for (std::size_t i = 0; i < plies.size(); ++i) {
    violated = violated || !record.violations[i].second.empty();
    text += ply_table(plies[i], record.job, record.violations[i].second);
    for (const std::string& warning : plies[i].report.warnings) {
      if (!arguments.quiet) print_warning("ply " + plies[i].name, warning);
    }
  }
  text += "wrote " + target + "/{paths.csv,tows.csv," + (arguments.coverage ? "coverage.csv," : "") +
          "paths.step,summary.json} in " + short_number(watch.total(), 3) +
          " s\n";
  if (arguments.json) {
    print(summary);
  } else if (!arguments.quiet) {
    print(text);
  }
  return arguments.strict && violated ? 1 : 0;
}

}  // namespace afptraj::cli
