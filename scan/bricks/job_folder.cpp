#include "scan/bricks/job_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/little_endian.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/version.h"
#include "fusion/bricks/brick_file.h"
#include "scan/bricks/brick_job.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlanMagic = "SKPLAN01";
constexpr std::size_t kHashBytes = std::tuple_size_v<Sha256>;
constexpr std::uintmax_t kMostPlanBytes = std::uintmax_t{16} << 30;
constexpr std::uintmax_t kMostConfigBytes = std::uintmax_t{1} << 20;

std::string hash_of(std::string_view bytes) {
  const Sha256 hash = sha256(bytes);
  return {hash.begin(), hash.end()};
}

void append_header_text(std::string& bytes, std::string_view text) {
  append_little_endian(bytes, static_cast<std::uint64_t>(text.size()));
  bytes += text;
}

std::string header_bytes(const JobHeader& header, std::size_t bricks) {
  std::string bytes;
  for (const std::string* text :
       {&header.version, &header.config_hash, &header.near_recording, &header.far_recording}) {
    append_header_text(bytes, *text);
  }
  for (const std::size_t number : {header.from, header.to, header.every, bricks, header.warnings.size()}) {
    append_little_endian(bytes, static_cast<std::uint64_t>(number));
  }
  for (const ScanWarning& warning : header.warnings) {
    append_little_endian(bytes, static_cast<std::uint8_t>(warning.code));
    append_header_text(bytes, warning.text);
  }
  return bytes;
}

bool read_text(ByteReader& reader, std::string& text) {
  const auto size = reader.little_endian<std::uint64_t>();
  if (!size || *size > reader.remaining()) return false;
  const auto bytes = *reader.take(static_cast<std::size_t>(*size));
  text.resize(bytes.size());
  std::transform(bytes.begin(), bytes.end(), text.begin(), [](std::byte byte) { return static_cast<char>(byte); });
  return true;
}

bool read_number(ByteReader& reader, std::size_t& number) {
  const auto value = reader.little_endian<std::uint64_t>();
  if (value) number = static_cast<std::size_t>(*value);
  return value.has_value();
}

bool read_warnings(ByteReader& reader, std::size_t count, std::vector<ScanWarning>& warnings) {
  for (; count > 0; --count) {
    const auto code = reader.little_endian<std::uint8_t>();
    std::string text;
    if (!code || *code > static_cast<std::uint8_t>(WarningCode::kClasses) || !read_text(reader, text)) return false;
    warnings.push_back({static_cast<WarningCode>(*code), std::move(text)});
  }
  return true;
}

bool read_rest_of_header(ByteReader& reader, JobHeader& header, std::size_t& bricks) {
  std::size_t warnings = 0;
  return read_text(reader, header.config_hash) && read_text(reader, header.near_recording) &&
         read_text(reader, header.far_recording) && read_number(reader, header.from) &&
         read_number(reader, header.to) && read_number(reader, header.every) && read_number(reader, bricks) &&
         read_number(reader, warnings) && read_warnings(reader, warnings, header.warnings);
}

Error no_job(const fs::path& folder, const char* what) {
  return {ErrorCode::kInput, std::string(what) + "; scanknit plan RECORDING -o JOB makes a job", folder.string()};
}

/// The bytes before the hash at the end; nothing if it is not theirs.
std::optional<std::string> hashed(const std::string& text) {
  if (text.size() < kPlanMagic.size() + kHashBytes || !text.starts_with(kPlanMagic)) return std::nullopt;
  std::string bytes = text.substr(0, text.size() - kHashBytes);
  if (hash_of(bytes) != text.substr(bytes.size())) return std::nullopt;
  return bytes;
}

}  // namespace

fs::path config_file_of_job(const fs::path& folder) {
  return folder / "config.yaml";
}

Result<void> JobFolder::write(const fs::path& folder, const JobHeader& header, const PlannedScan& planned,
                              const std::string& yaml) {
  JobHeader complete = header;
  complete.version = kVersion;
  complete.config_hash = hash_of(yaml);
  std::string bytes(kPlanMagic);
  bytes += header_bytes(complete, planned.parts.size());
  append_header_text(bytes, bytes_of(planned));
  bytes += hash_of(bytes);
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
  const auto bytes = hashed(*text);
  if (!bytes) return no_job(folder, "its plan is damaged");
  ByteReader reader(std::as_bytes(std::span(*bytes)).subspan(kPlanMagic.size()));
  JobFolder job;
  job.folder_ = folder;
  if (!read_text(reader, job.header_.version)) return no_job(folder, "its plan is damaged");
  if (job.header_.version != kVersion) {
    return Error{
        ErrorCode::kConfig,
        fmt::format("was planned by ScanKnit {}, and this is {}: use that one for all of a job, or plan it again",
                    job.header_.version, kVersion),
        folder.string()};
  }
  if (!read_rest_of_header(reader, job.header_, job.bricks_) || !read_text(reader, job.planned_)) {
    return no_job(folder, "its plan is damaged");
  }
  const auto yaml = read_text_file(config_file_of_job(folder), kMostConfigBytes);
  if (!yaml) return yaml.error();
  if (hash_of(*yaml) != job.header_.config_hash) {
    return Error{ErrorCode::kConfig, "was changed since the job was planned: give back what it was, or plan it again",
                 config_file_of_job(folder).string()};
  }
  const Sha256 hash = sha256(job.planned_);
  for (std::size_t i = 0; i < sizeof(job.id_); ++i) job.id_ = job.id_ << 8 | hash[i];
  return job;
}

fs::path JobFolder::recording() const {
  std::error_code code;
  const fs::path near = (folder_ / header_.near_recording).lexically_normal();
  return !header_.near_recording.empty() && fs::exists(near, code) ? near : fs::path(header_.far_recording);
}

Result<PlannedScan> JobFolder::planned(const FusionConfig& fusion) const {
  ByteReader reader(std::as_bytes(std::span(planned_)));
  auto planned = parse_planned(reader, fusion);
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

bool JobFolder::is_done(std::size_t number) const {
  return BrickFile::open(brick(number), id_).has_value();
}

}  // namespace scanknit
