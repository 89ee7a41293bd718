#include "app/job/plan_estimate.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "app/config/config_load.h"
#include "app/config/outputs.h"
#include "core/files/atomic_file.h"
#include "core/files/part_folder.h"
#include "scan/job/brick_job.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kMebibyte = 1024.0 * 1024.0;

Json cost_json(const JobEstimate::Cost& cost) {
  return {{"processor_s", cost.s}, {"bytes", cost.bytes}};
}

std::string cost_text(const char* what, const JobEstimate::Cost& cost, const std::string& note) {
  return fmt::format("  {:<7}{:.3g} s, {:.3g} MiB {}\n", what, cost.s, cost.bytes / kMebibyte, note);
}

}  // namespace

Result<JobEstimate> estimate_planned(const fs::path& job, std::size_t workers, double plan_s, double process_s,
                                     ScanObserver& observer, const std::stop_token& stop) {
  const auto loaded = load_config({.presets = {}, .file = config_file_of_job(job), .assignments = {}});
  if (!loaded) return loaded.error();
  const auto scratch = PartFolder::create(job / "estimate");
  if (!scratch) return scratch.error();
  const auto outputs = plan_outputs({.output = scratch->path() / "out"}, loaded->config.output);
  if (!outputs) return outputs.error();
  std::error_code code;
  if (!fs::create_directory(scratch->path() / "out", code)) {
    return Error{ErrorCode::kOutput, code.message(), scratch->path().string()};
  }
  const EstimateRequest request{job_of(job, *loaded, *outputs), scratch->path(), workers, plan_s, process_s};
  auto estimate = estimate_job(job, request, observer, stop);
  if (!estimate) return estimate;
  Json json = estimate_json(*estimate);
  Json& each = json["each_brick"] = Json::array();
  for (const JobEstimate::Brick& brick : estimate->bricks) {
    each.push_back(
        {{"frames", brick.frames}, {"blocks", brick.blocks}, {"processor_s", brick.s}, {"bytes", brick.bytes}});
  }
  if (auto written = write_file_atomically(job / "estimate.json", json.dump(1) + "\n"); !written) {
    return written.error();
  }
  return estimate;
}

Json estimate_json(const JobEstimate& estimate) {
  return {{"workers", estimate.workers},
          {"frames", estimate.frames},
          {"bricks", estimate.bricks.size()},
          {"seams", estimate.seams},
          {"sampled_bricks", estimate.sampled},
          {"processor_s",
           {{"plan", estimate.plan_s},
            {"work", estimate.work_s},
            {"join", estimate.join_s},
            {"all", estimate.plan_s + estimate.work_s + estimate.join_s}}},
          {"wall_s", estimate.wall_s},
          {"worker_mib", estimate.worker_mib},
          {"join_mib", estimate.join_mib},
          {"job_mib", estimate.folder_bytes / kMebibyte},
          {"triangles", estimate.triangles},
          {"start", cost_json(estimate.start)},
          {"frame", cost_json(estimate.frame)},
          {"brick", cost_json(estimate.brick)},
          {"seam", cost_json(estimate.seam)},
          {"join_start", cost_json(estimate.join_start)},
          {"join_processor_s_per_byte", estimate.join_s_per_byte}};
}

std::string estimate_text(const JobEstimate& estimate) {
  const std::string of = estimate.workers == 0   ? "workers that take single bricks"
                         : estimate.workers == 1 ? "1 worker"
                                                 : fmt::format("{} workers", estimate.workers);
  std::string text =
      fmt::format("Estimate {:.0f} s of a processor: plan {:.1f}, work {:.1f}, join {:.1f}; {:.0f} s for {}\n",
                  estimate.plan_s + estimate.work_s + estimate.join_s, estimate.plan_s, estimate.work_s,
                  estimate.join_s, estimate.wall_s, of);
  text += fmt::format("         memory of a worker {:.0f} MiB, of join {:.0f} MiB; the job's folder {:.0f} MiB\n",
                      estimate.worker_mib, estimate.join_mib, estimate.folder_bytes / kMebibyte);
  text += cost_text("frame", estimate.frame, "each time that it is read");
  text += cost_text("brick", estimate.brick, fmt::format("beside its frames ({} bricks)", estimate.bricks.size()));
  text += cost_text("seam", estimate.seam,
                    fmt::format("read anew if bricks are made one by one ({} seams)", estimate.seams));
  return text;
}

}  // namespace scanknit
