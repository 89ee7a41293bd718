#include "acquire/convert/cut_recording.h"

#include <system_error>
#include <utility>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"

namespace scanknit {
namespace fs = std::filesystem;

CutRecording::CutRecording(std::unique_ptr<RecordingTarget> target, fs::path folder)
    : target_(std::move(target)), folder_(std::move(folder)) {}
CutRecording::CutRecording(CutRecording&&) noexcept = default;

CutRecording::~CutRecording() {
  if (!target_ || is_finished_) return;
  target_.reset();
  std::error_code code;  // the folder was empty: all that is in it is ours
  fs::remove_all(folder_, code);
}

Result<void> CutRecording::check(const fs::path& folder) {
  std::error_code code;
  if (folder.empty()) return Error{ErrorCode::kOutput, "the folder for the cut recording has no name"};
  if (fs::exists(folder, code) && (!fs::is_directory(folder, code) || !fs::is_empty(folder, code))) {
    return Error{ErrorCode::kOutput, "is there already and not an empty folder; give the cut recording another one",
                 folder.string()};
  }
  fs::path first_new = folder;
  for (fs::path parent = folder; !parent.empty() && !fs::exists(parent, code); parent = parent.parent_path()) {
    first_new = parent;
  }
  const bool was_there = fs::exists(folder, code);
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), folder.string()};
  if (!was_there) fs::remove_all(first_new, code);
  return {};
}

Result<CutRecording> CutRecording::create(const fs::path& folder) {
  if (auto checked = check(folder); !checked) return checked.error();
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), folder.string()};
  auto target = open_open3d_target(folder);
  if (!target) return target.error();
  return CutRecording(*std::move(target), folder);
}

Result<void> CutRecording::write(const Frame& frame) {
  constexpr double kUnitsPerMetre = 10'000;  // up to 6.5 m
  constexpr std::int64_t kThirtieth_ns = 33'333'333;
  const auto raw = to_raw_depth(frame.depth_m, kUnitsPerMetre);
  const auto number = static_cast<std::int64_t>(written_);
  const std::int64_t time_ns = frame.has_clock ? frame.timestamp_ns : number * kThirtieth_ns;
  return target_->write({frame, raw, kUnitsPerMetre, written_++, time_ns});
}

Result<void> CutRecording::finish() {
  auto finished = target_->finish();
  is_finished_ = static_cast<bool>(finished);
  return finished;
}

}  // namespace scanknit
