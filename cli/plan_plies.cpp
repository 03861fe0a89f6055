#include "cli/plan_plies.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>

#include "analysis/judge_ply.h"
#include "cli/part_file.h"
#include "cli/signals.h"
#include "cli/terminal.h"

namespace afptraj::cli {
namespace {

// The bar of all plies: names the stage told last, shows the mean of how far they are.
class PliesProgress {
 public:
  PliesProgress(bool wanted, const std::vector<PlyOrientation>& orientations)
      : bar_(wanted), orientations_(orientations), done_(orientations.size(), 0.0) {}

  void show(std::size_t ply, const char* stage, double done) {
    const std::lock_guard lock(mutex_);
    done_[ply] = done;
    const std::string name = done_.size() > 1 ? "ply " + orientations_[ply].name + ", " : "";
    const double sum = std::accumulate(done_.begin(), done_.end(), 0.0);
    bar_.show(name + stage, sum / static_cast<double>(done_.size()));
  }

 private:
  std::mutex mutex_;
  ProgressBar bar_;
  const std::vector<PlyOrientation>& orientations_;
  std::vector<double> done_;
};

// The first of the plies that failed so far; those after it need not go on.
class FirstFailure {
 public:
  explicit FirstFailure(std::size_t count) : first_(count), failures_(count) {}

  bool before(std::size_t ply) const { return first_ < ply; }
  void note(std::size_t ply, std::exception_ptr failure) {
    failures_[ply] = std::move(failure);
    std::size_t first = first_;
    while (ply < first && !first_.compare_exchange_weak(first, ply)) {
    }
  }
  void rethrow() const {
    if (first_ < failures_.size()) std::rethrow_exception(failures_[first_]);
  }

 private:
  std::atomic<std::size_t> first_;
  std::vector<std::exception_ptr> failures_;
};

Ply plan_and_judge(const Skin& skin, const PlyOrientation& orientation, const Job& job, bool tow_coverage,
                   const Progress& progress) {
  PlanOptions options = plan_options(job);
  options.keep_tow_lines = tow_coverage;
  Ply ply = plan_ply(skin, orientation, options, progress);
  JudgeOptions judge;
  judge.band_width_mm = job.plan.band_width_mm();
  judge.tow_coverage = tow_coverage;
  judge_ply(skin, judge, ply);
  return ply;
}

}  // namespace

std::vector<Ply> plan_plies(const Skin& skin, const std::vector<PlyOrientation>& orientations,
                            const Arguments& arguments, const Job& job) {
  PliesProgress bar(!arguments.quiet && !arguments.json, orientations);
  FirstFailure failure(orientations.size());
  std::vector<Ply> plies(orientations.size());
  const auto plan = [&](std::size_t i) {
    if (failure.before(i)) return;
    const Progress progress = [&](const char* stage, double done) {
      bar.show(i, stage, done);
      return stop_signal() == 0 && !failure.before(i);
    };
    try {
      plies[i] = plan_and_judge(skin, orientations[i], job, arguments.coverage, progress);
      bar.show(i, "judged", 1);
    } catch (...) {
      failure.note(i, std::current_exception());
    }
  };
  // Isolated: a thread that waits for a loop of its ply does not begin another ply meanwhile.
  tbb::parallel_for(
      std::size_t{0}, orientations.size(), std::size_t{1},
      [&](std::size_t i) { tbb::this_task_arena::isolate([&] { plan(i); }); }, tbb::simple_partitioner());
  check_stop();
  failure.rethrow();
  return plies;
}

}  // namespace afptraj::cli
