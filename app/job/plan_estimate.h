// plan --estimate: what a job that was planned will take, for people and for programs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>

#include "core/result.h"
#include "scan/job/job_estimate.h"
#include "scan/scan_observer.h"

namespace scanknit {

/// Estimates the job, and writes JOB/estimate.json. `plan_s`, `process_s`: of EstimateRequest. Errors: those of
/// estimate_job(); kOutput.
[[nodiscard]] Result<JobEstimate> estimate_planned(const std::filesystem::path& job, std::size_t workers, double plan_s,
                                                   double process_s, ScanObserver& observer,
                                                   const std::stop_token& stop);

/// Without the single bricks, which only the file has.
[[nodiscard]] nlohmann::ordered_json estimate_json(const JobEstimate& estimate);
[[nodiscard]] std::string estimate_text(const JobEstimate& estimate);

}  // namespace scanknit
