// JobFolder: the files of a job that several processes scan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/result.h"
#include "scan/bricks/planned_scan.h"

namespace scanknit {

/// What the plan's file says beside PlannedScan.
struct JobHeader {
  std::string version;                        ///< kVersion of who planned it
  std::uint32_t config_checksum = 0;          ///< CRC-32 of config.yaml
  std::string near_recording, far_recording;  ///< from the folder, and from the root
  std::size_t from = 0, to = std::numeric_limits<std::size_t>::max(), every = 1;  ///< as in AcquireConfig
  std::vector<ScanWarning> warnings;                                              ///< of planning
};

class JobFolder {
 public:
  /// Writes `plan` and config.yaml, and makes the other folders. Errors: kOutput.
  [[nodiscard]] static Result<void> write(const std::filesystem::path& folder, const JobHeader& header,
                                          const PlannedScan& planned, const std::string& yaml);

  /// Errors: kInput when there is no plan, or a damaged one; kConfig when it is of another version, or config.yaml was
  /// changed.
  [[nodiscard]] static Result<JobFolder> open(const std::filesystem::path& folder);

  [[nodiscard]] const JobHeader& header() const { return header_; }
  /// The first of its two places at which there is something.
  [[nodiscard]] std::filesystem::path recording() const;
  /// Errors (kConfig): the recording, or its sensor, gives the volume other settings than it was planned with.
  [[nodiscard]] Result<PlannedScan> planned(const FusionConfig& fusion) const;

  [[nodiscard]] std::filesystem::path brick(std::size_t number) const;
  [[nodiscard]] std::filesystem::path claim(std::size_t number) const;
  /// plan_id().
  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] std::size_t bricks() const { return bricks_; }
  /// The bricks that have a file, whatever is in it, and those that have a claim: a listing of the folder. Ascending.
  [[nodiscard]] std::vector<std::size_t> with_file() const;
  [[nodiscard]] std::vector<std::size_t> with_claim() const;
  /// True if the brick's file is there, ends as it should, and belongs to the plan.
  [[nodiscard]] bool is_done(std::size_t number) const;

 private:
  std::filesystem::path folder_;
  JobHeader header_;
  std::string planned_;  ///< bytes_of()
  std::uint64_t id_ = 0;
  std::size_t bricks_ = 0;
};

}  // namespace scanknit
