#include "scan/frames/recorded_frames.h"

#include <string>
#include <utility>

#include "acquire/rig/rig_source.h"
#include "scan/frames/apply_sensor.h"
#include "scan/frames/only_frames.h"
#include "scan/frames/read_ahead.h"

namespace scanknit {

Result<std::unique_ptr<FrameSource>> open_recorded(const ScanJob& job, const AcquireConfig& config) {
  return job.rig ? open_rig(*job.rig, config) : open_recording(job.input, config);
}

Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, const SequenceRanges* only, std::size_t every) {
  AcquireConfig config = job.config.acquire;
  config.every *= every;
  auto source = open_recorded(job, config);
  if (!source) return source;
  if (only != nullptr) *source = std::make_unique<OnlyFrames>(*std::move(source), *only);
  return read_ahead(*std::move(source));
}

Result<OpenedRecording> open_first(ScanJob& job, ScanSession& session) {
  auto opened = open_recorded(job, job.config.acquire);
  if (!opened) return opened.error();
  for (const std::string& warning : (*opened)->info().warnings) session.warn(WarningCode::kRecording, warning);
  const auto timing = apply_sensor((*opened)->info().sensor, job.config, session);
  return OpenedRecording{read_ahead(*std::move(opened)), timing};
}

FrameArchive archive_of(const ScanJob& job, const SequenceRanges* only) {
  const auto open = [&job, only](std::size_t every) { return open_frames(job, only, every); };
  return only == nullptr ? FrameArchive(open) : FrameArchive(open, only->size());
}

}  // namespace scanknit
