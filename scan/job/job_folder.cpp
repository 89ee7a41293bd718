#include "scan/job/job_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/crc32.h"
#include "core/files/little_endian.h"
#include "core/files/read_file.h"
#include "core/version.h"
#include "fusion/bricks/brick_file.h"
#include "scan/bricks/plan_bytes.h"
#include "scan/job/brick_job.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlanMagic = "SKPLAN02";
constexpr std::size_t kChecksumBytes = sizeof(std::uint32_t);
constexpr std::uintmax_t kMostPlanBytes = std::uintmax_t{16} << 30;
constexpr std::uintmax_t kMostConfigBytes = std::uintmax_t{1} << 20;

std::string header_bytes(const JobHeader& header, std::size_t bricks) {
  std::string bytes;
  append_text(bytes, header.version);
  append_little_endian(bytes, header.config_checksum);
  append_text(bytes, header.near_recording);
  append_text(bytes, header.far_recording);
  for (const std::size_t number : {header.from, header.to, header.every, bricks, header.warnings.size()}) {
    append_count(bytes, number);
  }
  for (const ScanWarning& warning : header.warnings) {
    append_little_endian(bytes, static_cast<std::uint8_t>(warning.code));
    append_text(bytes, warning.text);
  }
  return bytes;
}

void take_rest_of_header(PlanReader& plan, JobHeader& header, std::size_t& bricks) {
  header.config_checksum = plan.number<std::uint32_t>();
  header.near_recording = plan.text();
  header.far_recording = plan.text();
  for (std::size_t* number : {&header.from, &header.to, &header.every, &bricks}) *number = plan.size();
  for (std::size_t left = plan.count(1 + sizeof(std::uint64_t)); left > 0; --left) {
    const auto code = plan.number<std::uint8_t>();
    plan.require(code <= static_cast<std::uint8_t>(WarningCode::kClasses));
    header.warnings.push_back({static_cast<WarningCode>(code), plan.text()});
  }
}

Error no_job(const fs::path& folder, const char* what) {
  return {ErrorCode::kInput, std::string(what) + "; scanknit plan RECORDING -o JOB makes a job", folder.string()};
}

/// The numbers N, less than `end`, of the files "N.ending".
std::vector<std::size_t> numbers_in(const fs::path& folder, std::string_view ending, std::size_t end) {
  std::vector<std::size_t> numbers;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), last; !code && entry != last; entry.increment(code)) {
    const std::string stem = entry->path().stem().string();
    std::size_t number = 0;
    const auto [read, fault] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    const bool is_number = fault == std::errc() && read == stem.data() + stem.size() && !stem.empty();
    if (is_number && number < end && entry->path().extension() == ending) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

std::uint32_t checksum_of(std::string_view bytes) {
  return crc32(std::as_bytes(std::span(bytes)));
}

/// What the file says: without its first bytes, and without the checksum of all before it. Nothing if that is wrong.
std::optional<std::string_view> checked(std::string_view file) {
  if (file.size() < kPlanMagic.size() + kChecksumBytes || !file.starts_with(kPlanMagic)) return std::nullopt;
  const std::string_view before = file.substr(0, file.size() - kChecksumBytes);
  std::string checksum;
  append_little_endian(checksum, checksum_of(before));
  if (file.substr(before.size()) != checksum) return std::nullopt;
  return before.substr(kPlanMagic.size());
}

}  // namespace

fs::path config_file_of_job(const fs::path& folder) {
  return folder / "config.yaml";
}

Result<void> JobFolder::write(const fs::path& folder, const JobHeader& header, const PlannedScan& planned,
                              const std::string& yaml) {
  JobHeader complete = header;
  complete.version = kVersion;
  complete.config_checksum = checksum_of(yaml);
  std::string bytes(kPlanMagic);
  bytes += header_bytes(complete, planned.parts.size());
  append_text(bytes, bytes_of(planned));
  append_little_endian(bytes, checksum_of(bytes));
  std::error_code code;
  for (const char* name : {"bricks", "claims"}) {
    if (!fs::create_directory(folder / name, code)) return Error{ErrorCode::kOutput, code.message(), folder.string()};
  }
  if (auto written = write_file_atomically(config_file_of_job(folder), yaml); !written) return written;
  return write_file_atomically(folder / "plan", bytes);
}

Result<JobFolder> JobFolder::open(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code) || !fs::exists(folder / "plan", code)) return no_job(folder, "is no job");
  const auto text = read_text_file(folder / "plan", kMostPlanBytes);
  if (!text) return text.error();
  const auto bytes = checked(*text);
  if (!bytes) return no_job(folder, "its plan is damaged");
  PlanReader plan{ByteReader(std::as_bytes(std::span(*bytes)))};
  JobFolder job;
  job.folder_ = folder;
  job.header_.version = plan.text();
  if (!plan.is_whole()) return no_job(folder, "its plan is damaged");
  if (job.header_.version != kVersion) {
    return Error{
        ErrorCode::kConfig,
        fmt::format("was planned by ScanKnit {}, and this is {}: use that one for all of a job, or plan it again",
                    job.header_.version, kVersion),
        folder.string()};
  }
  take_rest_of_header(plan, job.header_, job.bricks_);
  job.planned_ = plan.text();
  if (!plan.is_whole()) return no_job(folder, "its plan is damaged");
  const auto yaml = read_text_file(config_file_of_job(folder), kMostConfigBytes);
  if (!yaml) return yaml.error();
  if (checksum_of(*yaml) != job.header_.config_checksum) {
    return Error{ErrorCode::kConfig, "was changed since the job was planned: give back what it was, or plan it again",
                 config_file_of_job(folder).string()};
  }
  job.id_ = plan_id(job.planned_);
  return job;
}

fs::path JobFolder::recording() const {
  std::error_code code;
  const fs::path near = (folder_ / header_.near_recording).lexically_normal();
  return !header_.near_recording.empty() && fs::exists(near, code) ? near : fs::path(header_.far_recording);
}

Result<PlannedScan> JobFolder::planned(const FusionConfig& fusion) const {
  auto planned = parse_planned(planned_, fusion);
  if (planned && planned->parts.size() == bricks_) return *std::move(planned);
  return Error{ErrorCode::kConfig,
               "gives the volume other settings than it was planned with (its sensor?): plan it again",
               recording().string()};
}

fs::path JobFolder::brick(std::size_t number) const {
  return folder_ / "bricks" / fmt::format("{}.brick", number);
}

fs::path JobFolder::claim(std::size_t number) const {
  return folder_ / "claims" / fmt::format("{}.claim", number);
}

std::vector<std::size_t> JobFolder::with_file() const {
  return numbers_in(folder_ / "bricks", ".brick", bricks_);
}

std::vector<std::size_t> JobFolder::with_claim() const {
  return numbers_in(folder_ / "claims", ".claim", bricks_);
}

bool JobFolder::is_done(std::size_t number) const {
  return BrickFile::open(brick(number), id_).has_value();
}

}  // namespace scanknit
